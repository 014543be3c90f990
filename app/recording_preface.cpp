#include "app/recording_preface.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

#include <fmt/format.h>

#include "config/yaml_limits.h"
#include "hal/error.h"
#include "runtime/recorded_values.h"
#include "vision/rectify.h"

namespace headway::app {

namespace {

namespace fs = std::filesystem;
namespace ros = recording::ros;

constexpr std::size_t kMostRigFiles = 16;

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

runtime::Preface::File file_of(std::string name, const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw InputError(path.string() + ": can no longer be read, and belongs into the recording");
  return {std::move(name), "application/yaml", bytes_of(text)};
}

/// One file, or those of a folder.
void keep_rig(const fs::path& rig, runtime::Preface& preface) {
  if (!fs::is_directory(rig)) {
    const std::string name = kRigFolder + rig.filename().string();
    preface.files.push_back(file_of(name, rig));
    preface.facts["rig"] = name;
    return;
  }
  preface.facts["rig"] = "rig";
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(rig)) {
    const std::string kind = entry.path().extension();
    if (entry.is_regular_file() && (kind == ".yaml" || kind == ".yml")) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  if (files.size() > kMostRigFiles) files.resize(kMostRigFiles);
  for (const fs::path& file : files)
    preface.files.push_back(file_of(kRigFolder + fs::relative(file, rig).generic_string(), file));
}

ros::CameraInfo info_of(const vision::CameraIntrinsics& c, const Eigen::Matrix3d& rectified_from_raw,
                        const vision::RectifiedRig& rectified, bool right) {
  ros::CameraInfo info;
  info.header.frame_id = right ? "camera_right" : "camera_left";
  info.width = static_cast<std::uint32_t>(c.width);
  info.height = static_cast<std::uint32_t>(c.height);
  switch (c.lens) {
    case vision::LensModel::kRadialTangential:
      info.distortion_model = "plumb_bob";
      info.d = {c.k1, c.k2, c.p1, c.p2, c.k3};
      break;
    case vision::LensModel::kRational:
      info.distortion_model = "rational_polynomial";
      info.d = {c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6};
      break;
    case vision::LensModel::kEquidistant:
      info.distortion_model = "equidistant";
      info.d = {c.k1, c.k2, c.k3, c.k4};
      break;
  }
  info.k = {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1};
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.r.data()) = rectified_from_raw;
  const vision::PinholeCamera& p = rectified.camera;
  info.p = {p.focal, 0, p.cx, right ? -p.focal * rectified.baseline : 0, 0, p.focal, p.cy, 0, 0, 0, 1, 0};
  return info;
}

void keep_calibration(const vision::StereoRig& rig, runtime::Preface& preface) {
  const vision::Rectifier rectifier(rig);
  const Eigen::Matrix3d left = rectifier.rectified_from_left().linear(),
                        right = left * rig.right_from_left.linear().transpose();
  const auto keep = [&](runtime::Topic topic, const ros::CameraInfo& info) {
    preface.messages.push_back({topic, recording::to_cdr(info)});
  };
  keep(runtime::Topic::kLeftInfo, info_of(rig.left, left, rectifier.rig(), false));
  keep(runtime::Topic::kRightInfo, info_of(rig.right, right, rectifier.rig(), true));
}

/// A folder of its own, removed at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "headway_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw Error(name + ": a scratch folder cannot be made");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Whether a name leads to a place below the folder that it is put into.
bool stays_below(const fs::path& name) {
  return name.is_relative() && std::ranges::none_of(name, [](const fs::path& part) { return part == ".."; });
}

void put(const recording::McapAttachment& file, const fs::path& folder) {
  const fs::path path = folder / file.index.name;
  std::error_code ignored;
  fs::create_directories(path.parent_path(), ignored);
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(file.data.data()), static_cast<std::streamsize>(file.data.size()));
  out.close();
  if (!out) throw Error(path.string() + ": cannot be written");
}

}  // namespace

runtime::Preface recording_preface(const Robot& robot, const LoopSetup& setup, const std::string& command) {
  runtime::Preface preface;
  preface.files.push_back(file_of(kRobotFile, robot.file));
  keep_rig(robot.rig_path, preface);
  keep_calibration(robot.rig, preface);
  preface.facts["command"] = command;
  preface.facts["robot"] = robot.name;
  preface.facts["setup"] = to_json(setup).dump();
  return preface;
}

nav::SavedMap keep_known_map(const nav::SavedMap& known, runtime::Preface& preface) {
  std::stringstream file;
  nav::write_map_file(known.map, known.surfaces, file);
  preface.files.push_back({kKnownMap, "application/octet-stream", bytes_of(file.str())});
  return nav::read_saved_map(file, kKnownMap);
}

RecordedSetup recorded_setup(recording::McapReader& recording) {
  const auto facts = recording.metadata(runtime::kFactsName);
  const auto fail = [&](const std::string& what) -> void {
    throw InputError(fmt::format("{}: {}, expected a recording of 'headway run' or 'headway sim'",
                                 recording.name(), what));
  };
  if (!facts || !facts->contains("setup") || !facts->contains("rig"))
    fail("does not say how the loops were set up");
  const ScratchFolder scratch;
  for (const recording::McapAttachmentIndex& index : std::vector(recording.attachments())) {
    const bool wanted = index.name == kRobotFile || index.name.starts_with(kRigFolder);
    if (!wanted || !stays_below(index.name)) continue;
    const auto file = recording.attachment(index);
    if (!file) fail(fmt::format("its {:.60} is damaged", index.name));
    put(*file, scratch.path());
  }
  const fs::path rig = facts->at("rig");
  if (!stays_below(rig)) fail("names a rig outside of it");
  try {
    RecordedSetup out{{}, loop_setup_from(facts->at("setup")), {}};
    out.robot = with(out.setup, read_robot(scratch.path() / kRobotFile, scratch.path() / rig));
    const auto has = [&](const auto& index) { return index.name == kKnownMap; };
    if (std::ranges::none_of(recording.attachments(), has)) return out;
    const auto known = recording.attachment(kKnownMap);
    if (!known) throw InputError("the map known from before is damaged");
    std::istringstream in(std::string(reinterpret_cast<const char*>(known->data.data()), known->data.size()));
    out.known = nav::read_saved_map(in, kKnownMap);
    return out;
  } catch (const InputError& fault) {
    throw InputError(fmt::format("{}: {}", recording.name(), fault.what()));
  }
}

}  // namespace headway::app
