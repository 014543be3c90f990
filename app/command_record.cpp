// headway record: what a recording holds, and its parts as files that other tools read.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "app/commands.h"
#include "app/output_folder.h"
#include "app/recording_info.h"
#include "hal/error.h"
#include "nav/floor_files.h"
#include "runtime/topics.h"

namespace headway::app {

namespace {

using runtime::Topic;
namespace ros = recording::ros;

struct Options {
  std::filesystem::path file, out;
  bool json = false;
};

int info(const Options& options) {
  recording::McapReader file(options.file);
  const RecordingInfo info = inspect(file);
  fmt::print("{}", options.json ? to_json(info).dump(2) + "\n" : to_text(info));
  return info.whole() ? kSuccess : kNotReached;
}

/// Writes what it is shown into a folder.
class Extractor {
 public:
  explicit Extractor(OutputFolder& out) : out_(out) {}

  void attachment(const recording::McapAttachment& file) {
    std::string name = "attached_" + file.index.name;
    for (char& c : name)
      if (c == '/') c = '_';
    std::ofstream stream(out_.file(name), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(file.data.data()),
                 static_cast<std::streamsize>(file.data.size()));
    stream.close();
    if (!stream) throw Error(name + ": cannot be written");
  }

  void message(Topic topic, const recording::McapMessage& message) {
    if (topic == Topic::kCanReceived || topic == Topic::kCanSent)
      frame(recording::from_cdr<ros::CanFrame>(message.bytes), message.log_time, topic == Topic::kCanSent);
    else if (topic == Topic::kMap)
      map(recording::from_cdr<ros::OccupancyGrid>(message.bytes));
    else if (topic == Topic::kLeft)
      image("left", recording::from_cdr<ros::Image>(message.bytes), message.sequence);
    else if (topic == Topic::kRight)
      image("right", recording::from_cdr<ros::Image>(message.bytes), message.sequence);
    else if (topic == Topic::kDepth)
      image("depth", recording::from_cdr<ros::Image>(message.bytes), message.sequence);
  }

  Json counts() const { return {{"images", images_}, {"can_frames", frames_}, {"maps", maps_}}; }

  void finish() {
    can_.close();
    if (frames_ > 0 && !can_) throw Error("can.log: cannot be written");
  }

 private:
  /// As candump -L -x writes them.
  void frame(const ros::CanFrame& frame, Time time, bool sent) {
    if (frames_++ == 0) can_.open(out_.file("can.log"));
    const auto ns = time.time_since_epoch().count();
    std::string data;
    for (std::size_t i = 0; i < std::min<std::size_t>(frame.dlc, frame.data.size()); ++i)
      data += fmt::format("{:02X}", frame.data[i]);
    can_ << fmt::format("({}.{:09}) can0 {:03X}#{} {}\n", ns / 1'000'000'000, ns % 1'000'000'000, frame.id,
                        data, sent ? 'T' : 'R');
  }

  /// Grey values as they are; depth in millimetres, 16 bits, 0 where nothing was measured.
  void image(const char* name, const ros::Image& image, std::uint32_t number) {
    constexpr std::uint32_t kLargest = 1 << 15;
    const std::uint64_t pixels = std::uint64_t{image.width} * image.height;
    const bool gray = image.encoding == "mono8";
    if (image.width > kLargest || image.height > kLargest ||
        image.data.size() != pixels * (gray ? 1 : sizeof(float)))
      return;
    const int rows = static_cast<int>(image.height), columns = static_cast<int>(image.width);
    cv::Mat picture(rows, columns, gray ? CV_8UC1 : CV_16UC1);
    if (gray) {
      std::memcpy(picture.data, image.data.data(), image.data.size());
    } else {
      for (std::size_t i = 0; i < pixels; ++i) {
        float z = 0;
        std::memcpy(&z, image.data.data() + i * sizeof z, sizeof z);
        const bool fits = z > 0 && z < 65.5F;
        picture.ptr<std::uint16_t>()[i] =
            fits ? static_cast<std::uint16_t>(std::lround(z * 1000)) : std::uint16_t{0};
      }
    }
    const std::filesystem::path file = out_.file(fmt::format("{}_{:06}.png", name, number));
    if (!cv::imwrite(file.string(), picture)) throw Error(file.string() + ": cannot be written");
    ++images_;
  }

  void map(const ros::OccupancyGrid& grid) {
    const std::uint64_t cells = std::uint64_t{grid.info.width} * grid.info.height;
    constexpr std::uint32_t kLargest = 1 << 15;
    if (grid.info.width > kLargest || grid.info.height > kLargest || grid.data.size() != cells) return;
    nav::FloorGrid place;
    place.resolution = std::round(static_cast<double>(grid.info.resolution) * 1e6) * 1e-6;
    place.origin = {grid.info.origin.position.x, grid.info.origin.position.y};
    place.width = static_cast<int>(grid.info.width);
    place.height = static_cast<int>(grid.info.height);
    nav::FloorMap floor = nav::unseen_floor(place);
    for (std::size_t i = 0; i < grid.data.size(); ++i)
      if (grid.data[i] >= 0) floor.cells[i] = grid.data[i] < 50 ? nav::Floor::kFree : nav::Floor::kBlocked;
    const std::string name = fmt::format("map_{:04}", maps_++);
    out_.file(name + ".pgm");
    out_.file(name + ".yaml");
    nav::write_map_server(floor, out_.path(), name);
  }

  OutputFolder& out_;
  std::ofstream can_;
  std::uint64_t images_ = 0, frames_ = 0, maps_ = 0;
};

int extract(const Options& options) {
  recording::McapReader file(options.file);
  OutputFolder out(options.out, "record extract");
  Extractor extractor(out);
  for (const recording::McapAttachmentIndex& index : std::vector(file.attachments()))
    if (const auto attachment = file.attachment(index)) extractor.attachment(*attachment);
  std::map<std::uint16_t, Topic> topics;
  std::set<std::uint16_t> channels;
  for (const Topic topic :
       {Topic::kCanReceived, Topic::kCanSent, Topic::kMap, Topic::kLeft, Topic::kRight, Topic::kDepth}) {
    const auto channel = file.channel(runtime::kind(topic).name);
    if (channel) topics[*channel] = topic;
    if (channel) channels.insert(*channel);
  }
  try {
    if (!channels.empty())
      file.for_each(channels, [&](const recording::McapMessage& message) {
        extractor.message(topics.at(message.channel), message);
      });
  } catch (const recording::CdrError& fault) {
    throw InputError(fmt::format("{}: a message {}, expected one of 'headway run' or 'headway sim'",
                                 file.name(), fault.what()));
  }
  extractor.finish();
  Json report{{"recording", options.file.string()}};
  report.update(extractor.counts());
  for (const recording::McapLoss& loss : file.losses())
    fmt::print("lost: {} bytes from {} on: {}\n", loss.bytes, loss.at, loss.what);
  out.report(report);
  fmt::print("{}: {}\n", out.path().string(), extractor.counts().dump());
  return kSuccess;
}

}  // namespace

void add_record(CLI::App& app, Run& run_command) {
  CLI::App* command =
      app.add_subcommand("record", "What a recording holds (info), and its parts as files (extract)");
  command->require_subcommand(1);
  auto options = std::make_shared<Options>();
  CLI::App* show =
      command->add_subcommand("info", "Topics, counts, gaps, what was dropped and what was lost");
  show->add_option("recording", options->file, "A recording (.mcap)")->required()->type_name("FILE");
  show->add_flag("--json", options->json, "As JSON");
  show->footer(
      "Reads every byte, so that damage shows. Exit code 0 when the file is whole, 1 when it is not.");
  show->callback([options, &run_command] { run_command = [options] { return info(*options); }; });
  CLI::App* take = command->add_subcommand("extract", "Images, CAN frames, maps and attachments as files");
  take->add_option("recording", options->file, "A recording (.mcap)")->required()->type_name("FILE");
  take->add_option("--out", options->out, kOutHelp)->required()->type_name("DIR");
  take->footer(
      "Images as PNG (depth in millimetres, 16 bits), CAN frames as can.log as candump -L -x writes it "
      "(stamps of\n"
      "the run's clock), maps as map_server's .pgm and .yaml.");
  take->callback([options, &run_command] { run_command = [options] { return extract(*options); }; });
}

}  // namespace headway::app
