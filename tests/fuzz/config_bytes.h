// Any bytes as a file that a person has written: robot, world, rig, fault plan, head. What fuzzers and
// mutation tests throw at the readers, and whole files to begin with.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/robot_file.h"
#include "hal/error.h"
#include "sim_hal/fault_file.h"
#include "sim_hal/world_file.h"
#include "tests/fuzz/promise.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"
#include "vision/head_file.h"
#include "vision/rig_files.h"

namespace headway::fuzz {

/// Rectified already, so that a robot with it is read in a moment.
inline const std::string kSmallRig =
    "name: small\nsize: [96, 72]\nleft: {focal: [90, 90], centre: [47.5, 35.5]}\n"
    "right: {focal: [90, 90], centre: [47.5, 35.5]}\nright_from_left: {translation: [-0.1, 0, 0]}\n"
    "nearest: 0.5\nfarthest: 6\n";

/// The folder that the files are read from; in memory where TMPDIR is.
class ConfigFolder {
 public:
  ConfigFolder() { write_text(folder_ / "small.yaml", kSmallRig); }
  std::filesystem::path small_rig() const { return folder_ / "small.yaml"; }
  std::filesystem::path write(const char* name, std::string_view bytes) const {
    write_text(folder_ / name, std::string(bytes));
    return folder_ / name;
  }
  std::string path() const { return folder_.path().string(); }

 private:
  TemporaryFolder folder_;
};

inline void read_robot(const ConfigFolder& folder, std::string_view bytes) {
  const app::Robot robot = app::read_robot(folder.write("robot.yaml", bytes), folder.small_rig());
  robot.mission.gait.validate();
  robot.mission.outline.validate();
  robot.mission.planner.validate();
  robot.mapper.floor.validate();
  robot.simulation.body.validate();
  promise(!robot.mission.viewpoints.empty(), "a robot has directions to look at");
}

inline void read_world(const ConfigFolder& folder, std::string_view bytes) {
  const sim::World world = sim::read_world(folder.write("world.yaml", bytes));
  for (const sim::Solid& solid : world.solids())
    promise(solid.pose.position().allFinite() && std::isfinite(solid.pose.yaw), "solids have a place");
  for (const sim::MovingThing& thing : world.moving)
    for (std::size_t i = 0; i < thing.path.size(); ++i)
      promise(thing.path[i].after >= (i == 0 ? Duration{} : thing.path[i - 1].after + Duration(1)),
              "what moves is at one place after the other");
}

inline void read_rig(const ConfigFolder& folder, std::string_view bytes) {
  const vision::StereoRig rig = vision::read_rig(folder.write("rig.yaml", bytes));
  promise(!vision::fault_of(rig), "a rig that was read is usable");
}

/// Two files, with a zero byte in between.
inline void read_rigs(const ConfigFolder& folder, std::string_view bytes) {
  const std::size_t end = bytes.find('\0');
  const auto left = folder.write("left.yaml", bytes.substr(0, end));
  const auto right =
      folder.write("right.yaml", end == bytes.npos ? std::string_view() : bytes.substr(end + 1));
  const vision::StereoRig rig = vision::read_rig(left.string() + "," + right.string());
  promise(!vision::fault_of(rig), "a rig that was read is usable");
}

inline void read_faults(const ConfigFolder& folder, std::string_view bytes) {
  sim::validate(sim::read_faults(folder.write("faults.yaml", bytes)));
}

inline void read_head(const ConfigFolder& folder, std::string_view bytes) {
  const vision::CameraHead head = vision::read_head(folder.write("head.yaml", bytes));
  promise(!head.rigs.empty(), "a head has rigs");
  for (const vision::HeadRig& rig : head.rigs)
    promise(!vision::fault_of(rig.rig), "a rig that was read is usable");
}

using ConfigReader = std::function<void(const ConfigFolder&, std::string_view)>;

/// The first byte of an input chooses among them.
inline const std::array<ConfigReader, 6>& config_readers() {
  static const std::array<ConfigReader, 6> all{read_robot, read_world,  read_rig,
                                               read_rigs,  read_faults, read_head};
  return all;
}

/// True when the input is a whole file, false when it was refused with InputError, in one line that begins
/// with the file; lets every other exception out.
inline bool is_config(std::string_view input) {
  static const ConfigFolder folder;
  if (input.empty()) return false;
  const ConfigReader& read = config_readers()[static_cast<unsigned char>(input[0]) % config_readers().size()];
  try {
    read(folder, input.substr(1));
    return true;
  } catch (const InputError& fault) {
    const std::string_view what = fault.what();
    promise(what.starts_with(folder.path()), "a refusal begins with the file", what);
    promise(is_plain_text(what), "a refusal is one line of plain text", what);
    return false;
  }
}

/// Without comments: they would only make the fuzzer slow.
inline std::string without_comments(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line = text.substr(at, end - at);
    const std::size_t comment = line.starts_with('#') ? 0 : line.find(" #");
    line.resize(std::min(comment, line.size()));
    line.resize(line.find_last_not_of(' ') + 1);
    if (!line.empty()) out += line + "\n";
    at = end + 1;
  }
  return out;
}

inline const std::string kHardware =
    "hardware:\n  bus: socketcan:can0\n  cameras: {left: /dev/a, right: /dev/b, format: GREY, rate: 15, "
    "exposure_ms: 8, "
    "gain: 20, white_balance: 4600}\n  head:\n    set_points: cyclic\n    homing: {move: true, method: 17, "
    "speed_deg_s: 5, zero_speed_deg_s: 1, acceleration_deg_s2: 30, longest_seconds: 60}\n";

inline const std::string kEveryThing =
    "name: all\nseed: 2\nstart: [0, 0, 10]\ngoal: [1, 1]\ngoal_yaw_deg: 90\nlight: {at: [0, 0, 2], ambient: "
    "0.5}\n"
    "textures: [{name: a, kind: checker, brightness: 0.5, contrast: 0.5, grain: 0.01, octaves: 2}]\n"
    "floor: {centre: [0, 0], size: [8, 8], texture: a}\nwalls: [{from: [-3, 2], to: [3, 2], height: 2}]\n"
    "cylinders: [{base: [2, -2, 0], radius: 0.2, height: 1}]\n"
    "tables: [{at: [-2, -2, 30], size: [1, 0.6, 0.7], stands_on: panels}]\n"
    "shelves: [{at: [-2, 1, 0], size: [0.4, 1, 1.8], boards: 3}]\n"
    "moving:\n- {name: m, cylinder: {radius: 0.2, height: 1}, starts_when: {robot_sees: 1, warning: 1}, "
    "path: [{x: 3, y: 3}, {t: 2, x: 3, y: 2, yaw_deg: 5}]}\n"
    "- {name: n, box: {size: [1, 1, 1], bottom: 1}, starts_when: {at_time: 3}, speed: 1, path: [{x: 3, y: "
    "3}]}\n";

inline const std::string kKalibrChain =
    "cam0: {camera_model: pinhole, distortion_coeffs: [0, 0, 0, 0], distortion_model: equidistant, "
    "intrinsics: [190, "
    "190, 255, 255], resolution: [512, 512]}\n"
    "cam1: {T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], camera_model: pinhole, "
    "distortion_coeffs: [-0.2, 0.05, 0, 0], distortion_model: radtan, intrinsics: [290, 290, 252, 255], "
    "resolution: [512, 512]}\n";

inline const std::string kOpenCv =
    "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
    "M1: !!opencv-matrix\n   {rows: 3, cols: 3, dt: d, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}\n"
    "D1: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}\n"
    "M2: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}\nD2: {rows: 0, cols: 0, data: []}\n";

inline const std::string kOpenCvPose =
    "R: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\nT: {rows: 3, cols: 1, data: [-0.1, 0, 0]}\n";

/// Of ROS; `shift` is projection_matrix[0, 3].
inline std::string camera_info(const std::string& shift) {
  return "image_width: 640\nimage_height: 480\ndistortion_model: plumb_bob\n"
         "camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}\n"
         "distortion_coefficients: {rows: 1, cols: 5, data: [-0.2, 0.06, 0, 0, 0]}\n"
         "rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n"
         "projection_matrix: {rows: 3, cols: 4, data: [450, 0, 320, " +
         shift + ", 0, 450, 240, 0, 0, 0, 1, 0]}\n";
}

/// Of EuRoC's data sets, `y` [m] to the left on the body.
inline std::string euroc_sensor(const std::string& y) {
  return "sensor_type: camera\nT_BS: {cols: 4, rows: 4, data: [0, 0, 1, 0, -1, 0, 0, " + y +
         ", 0, -1, 0, 0, 0, 0, 0, 1]}\nresolution: [752, 480]\ncamera_model: pinhole\nintrinsics: [458, 457, "
         "367, "
         "248]\ndistortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0, 0]\n";
}

/// At least one whole file for each reader.
inline std::vector<std::string> whole_configs() {
  const auto of_tree = [](const char* file) {
    return without_comments(read_text(source_dir() / "config" / file));
  };
  const std::string robot = of_tree("hrp2/robot.yaml");
  std::vector<std::string> inputs;
  const auto add = [&](char reader, const std::string& text) { inputs.push_back(reader + text); };
  add(0, robot);
  add(0, robot + kHardware);
  add(1, of_tree("worlds/moving_box.yaml"));
  add(1, kEveryThing);
  add(2, kSmallRig);
  add(2, of_tree("hrp2/rigs/bottom.yaml"));
  add(2, kKalibrChain);
  add(2, kOpenCv + kOpenCvPose);
  const std::string between(1, '\0');
  add(3, camera_info("0") + between + camera_info("-54"));
  add(3, euroc_sensor("0.05") + between + euroc_sensor("-0.05"));
  add(3, kOpenCv + between + kOpenCvPose);
  add(4, of_tree("faults/three.yaml"));
  add(4,
      "faults:\n- {kind: control_clock_jump, begin_s: 0, jump_s: 1}\n- {kind: can_delay, begin_s: 1, "
      "length_s: 2, id: 5, delay_s: 1}\n");
  add(5, of_tree("hrp2/head.yaml"));
  return inputs;
}

}  // namespace headway::fuzz
