#include "vision/rig_files.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "config/yaml_limits.h"
#include "vision/calibration_file.h"

namespace headway::vision {

namespace fs = std::filesystem;
using config::Section;

namespace {

enum class Format { kHeadway, kCameraInfo, kKalibr, kOpenCv, kOpenCvExtrinsics, kEuroc };

// By keys that no other format has.
Format format_of(const Section& section) {
  const auto has = [&](std::initializer_list<const char*> keys) {
    return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return section.has(key); });
  };
  if (has({"right_from_left", "left", "right"})) return Format::kHeadway;
  if (has({"cam0", "cam1"})) return Format::kKalibr;
  if (has({"T_BS", "sensor_type"})) return Format::kEuroc;
  if (has({"projection_matrix", "rectification_matrix"})) return Format::kCameraInfo;
  if (has({"M1", "M2", "K1", "K2", "cameraMatrix1", "camera_matrix_1"})) return Format::kOpenCv;
  if (has({"R", "T"})) return Format::kOpenCvExtrinsics;
  section.fail("",
               "no calibration of two cameras that is known here, expected a rig of ours (name, size, left, "
               "right, right_from_left), ROS camera_info, Kalibr's camchain, OpenCV's M1 D1 M2 D2 R T, or "
               "EuRoC's sensor.yaml");
}

StereoRig read_own(const fs::path& file) {
  const Section section = Section::load(file, "rig");
  StereoRig rig = rig_from(section);
  section.finish();
  return rig;
}

StereoRig read_one(const fs::path& file, const RigDefaults& defaults) {
  const Section section = load_calibration(file);
  switch (format_of(section)) {
    case Format::kHeadway:
      return read_own(file);
    case Format::kKalibr:
      return rig_from_kalibr(section, defaults);
    case Format::kOpenCv:
      return rig_from_opencv(section, section, defaults);
    case Format::kOpenCvExtrinsics:
      section.fail("", "holds only the cameras' poses, expected both files: intrinsics.yml,extrinsics.yml");
    case Format::kCameraInfo:
    case Format::kEuroc:
      section.fail("", "describes one camera, expected the files of both, left first: left.yaml,right.yaml");
  }
  return {};
}

StereoRig read_two(const fs::path& one, const fs::path& other, const RigDefaults& defaults) {
  const Section a = load_calibration(one), b = load_calibration(other);
  const Format first = format_of(a), second = format_of(b);
  if (first == Format::kCameraInfo && second == first) return rig_from_camera_infos(a, b, defaults);
  if (first == Format::kEuroc && second == first) return rig_from_euroc(a, b, defaults);
  if (first == Format::kOpenCv && second == Format::kOpenCvExtrinsics) return rig_from_opencv(a, b, defaults);
  if (first == Format::kOpenCvExtrinsics && second == Format::kOpenCv) return rig_from_opencv(b, a, defaults);
  b.fail("", fmt::format(
                 "does not go with {}, expected camera_info or sensor.yaml of a left and a right camera, or "
                 "intrinsics.yml and extrinsics.yml",
                 config::one_line(one.string())));
}

using Pair = std::pair<fs::path, fs::path>;

// The two files in a folder, by the names that the tools give them.
Pair pair_in(const fs::path& folder) {
  static const std::array<Pair, 4> names{{{"cam0/sensor.yaml", "cam1/sensor.yaml"},
                                          {"left.yaml", "right.yaml"},
                                          {"intrinsics.yml", "extrinsics.yml"},
                                          {"intrinsics.yaml", "extrinsics.yaml"}}};
  std::error_code ec;
  for (const auto& [one, other] : names)
    if (fs::is_regular_file(folder / one, ec) && fs::is_regular_file(folder / other, ec))
      return {folder / one, folder / other};
  throw InputError(
      fmt::format("{}: holds no calibration, expected left.yaml and right.yaml, cam0/sensor.yaml and "
                  "cam1/sensor.yaml, intrinsics.yml and extrinsics.yml, or rig.yaml",
                  config::one_line(folder.string())));
}

std::optional<Pair> split(const fs::path& path) {
  const std::string text = path.string();
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos) return std::nullopt;
  return Pair{text.substr(0, comma), text.substr(comma + 1)};
}

}  // namespace

StereoRig read_rig(const fs::path& path, const RigDefaults& defaults) {
  std::error_code ec;
  if (fs::is_directory(path, ec)) {
    if (fs::is_regular_file(path / "rig.yaml", ec)) return read_one(path / "rig.yaml", defaults);
    const auto [one, other] = pair_in(path);
    StereoRig rig = read_two(one, other, defaults);
    rig.name = path.string();
    return rig;
  }
  const auto two = fs::exists(path, ec) ? std::nullopt : split(path);
  return two ? read_two(two->first, two->second, defaults) : read_one(path, defaults);
}

StereoRig read_euroc_rig(const fs::path& dir, const RigDefaults& defaults) {
  StereoRig rig = read_two(dir / "cam0" / "sensor.yaml", dir / "cam1" / "sensor.yaml", defaults);
  rig.name = dir.string();
  return rig;
}

}  // namespace headway::vision
