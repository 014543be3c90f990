// hil_usb_camera: an emulated camera of the USB Video Class, plugged into the kernel that it runs on.

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "hal/clock.h"
#include "hal/error.h"
#include "tests/hil/emulated_uvc.h"
#include "tests/hil/live_frames.h"
#include "tests/hil/usb_program.h"

namespace headway::hil {
namespace {

constexpr const char* kCommands = R"(Commands, one a line, into the pipe:
  plug | unplug
  stall 0x81 | stall 0   the frames' endpoint until the host clears it, or the next control request
  next half              the next frame ends after its first half
  pause | resume         the stream is on, and no frame comes)";

// Frames of a file that holds them back to back: all of one size, or JPEG images, which begin where the one
// before has ended.
std::vector<ByteSpan> frames_in(ByteSpan bytes, std::size_t size, bool jpeg) {
  std::vector<ByteSpan> frames;
  while (!jpeg && bytes.size() >= size) {
    frames.push_back(bytes.first(size));
    bytes = bytes.subspan(size);
  }
  constexpr std::array<std::uint8_t, 2> kEnd{0xFF, 0xD9};
  while (jpeg && !bytes.empty()) {
    const auto end = std::search(bytes.begin(), bytes.end(), kEnd.begin(), kEnd.end());
    if (end == bytes.end()) break;
    frames.push_back(bytes.first(static_cast<std::size_t>(end - bytes.begin()) + kEnd.size()));
    bytes = bytes.subspan(frames.back().size());
  }
  if (!bytes.empty()) frames.clear();
  return frames;
}

// One frame after the other from a file, and from its beginning again.
class FrameFile {
 public:
  FrameFile(const std::string& path, std::size_t size, bool jpeg) {
    std::ifstream file(path, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(file), {});
    frames_ = frames_in(bytes_, size, jpeg);
    if (frames_.empty())
      throw InputError(
          jpeg ? fmt::format("{}: {} bytes; expected one or more whole JPEG images", path, bytes_.size())
               : fmt::format("{}: {} bytes; expected one or more frames of {} bytes each", path,
                             bytes_.size(), size));
  }

  ByteSpan next() { return frames_[std::exchange(next_, (next_ + 1) % frames_.size())]; }

 private:
  Bytes bytes_;
  std::vector<ByteSpan> frames_;
  std::size_t next_ = 0;
};

bool obey(EmulatedUvc& camera, const Command& command) {
  if (command == Command{"next", "half"}) {
    camera.cut_next_frame();
  } else if (command == Command{"pause"} || command == Command{"resume"}) {
    camera.pause(command[0] == "pause");
  } else {
    return false;
  }
  return true;
}

// Milliseconds, rounded up; -1 while no frame is wanted or due.
int wait_for_frame(const UsbipPort& port, const EmulatedUvc& camera, Time now) {
  const auto due = camera.due();
  if (!port.is_waiting() || !due) return -1;
  const auto nanoseconds = std::max<std::int64_t>((*due - now).count(), 0);
  return static_cast<int>((nanoseconds + 999'999) / 1'000'000);
}

int run(int argc, char** argv) {
  EmulatedUvc::Config config;
  std::string frames, live, pipe;
  std::pair<std::uint16_t, std::uint16_t> size{config.width, config.height};
  unsigned port_number = 0;
  using Format = EmulatedUvc::Config::Format;
  const std::map<std::string, Format> formats{
      {"grey", Format::kGrey}, {"yuyv", Format::kYuyv}, {"z16", Format::kZ16}, {"mjpeg", Format::kMjpeg}};

  CLI::App app("An emulated camera of the USB Video Class, plugged into this kernel until it is ended.");
  app.footer(kCommands);
  auto* still =
      app.add_option("--frames", frames, "File of the frames that it films, back to back and again");
  auto* moving = app.add_option("--live", live, "Named pipe that the frames come from as they are filmed");
  still->excludes(moving);
  app.add_option("--size", size, "Width and height, as in: --size 640 480");
  app.add_option("--format", config.format, "grey, yuyv, z16 or mjpeg")
      ->transform(CLI::CheckedTransformer(formats));
  app.add_option("--serial", config.serial, "Its serial number")->capture_default_str();
  app.add_option("--port", port_number, "Port of the virtual USB host, 0 to 7")->capture_default_str();
  app.add_option("--commands", pipe, "The named pipe that it makes and obeys")->required();
  CLI11_PARSE(app, argc, argv);
  std::tie(config.width, config.height) = size;
  config.validate();

  if (frames.empty() == live.empty()) throw InputError("expected --frames or --live");
  if (!live.empty() && config.format == Format::kMjpeg)
    throw InputError("--live: frames of one size, expected another --format than mjpeg");

  const hal::MonotonicClock clock;
  std::optional<FrameFile> file;
  std::optional<LiveFrames> filmed;
  if (live.empty())
    file.emplace(frames, config.frame_size(), config.format == Format::kMjpeg);
  else
    filmed.emplace(live, config.frame_size());
  EmulatedUvc camera(
      config, [&] { return file ? file->next() : filmed->take(); }, clock);
  UsbipPort port(camera, attach_to_kernel(port_number));
  CommandPipe commands(pipe);
  run_usb_program(
      port, commands, [&](const Command& command) { return obey(camera, command); },
      [&] {
        if (filmed) {
          filmed->read();
          camera.pause(!filmed->fresh());
          return 5;
        }
        return wait_for_frame(port, camera, clock.now());
      });
  return 0;
}

}  // namespace
}  // namespace headway::hil

int main(int argc, char** argv) {
  return headway::hil::run_reporting("hil_usb_camera", headway::hil::run, argc, argv);
}
