#include "app/robot_file.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "app/can_transport.h"
#include "app/file_kind.h"
#include "config/yaml_limits.h"
#include "config/yaml_reader.h"
#include "hal/angle.h"
#include "hal/error.h"
#include "vision/rectify.h"
#include "vision/rig_files.h"
#include "vision/rig_polytope.h"
#include "vision/viewpoints.h"

namespace headway::app {

namespace {

using config::Range;
using config::Section;

Eigen::Isometry3d offset(const Section& section, std::string_view key) {
  const auto v = section.numbers(key, 3, {-2, 2, "m"});
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  t.translation() << v[0], v[1], v[2];
  return t;
}

/// What a part's own check refuses ("part: key: what" or "part: key what"), with its place in the file.
template <class Part>
void check(const Section& section, const Part& part) {
  try {
    part.validate();
  } catch (const InputError& fault) {
    std::string_view what = fault.what();
    if (const auto colon = what.find(": "); colon != what.npos) what.remove_prefix(colon + 2);
    const std::string_view key = what.substr(0, what.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"));
    if (!section.has(key)) section.fail("", std::string(what));
    what.remove_prefix(std::min(what.size(), what.find_first_not_of(": ", key.size())));
    section.fail(key, std::string(what));
  }
}

/// A rotation as axis times angle; none where the key is absent.
Eigen::Matrix3d turn_if(const Section& section, std::string_view key) {
  const auto v = section.numbers_if(key, 3, {-20, 20, "deg"}).value_or(std::vector<double>(3, 0));
  const Eigen::Vector3d turn = kDegree * Eigen::Vector3d(v[0], v[1], v[2]);
  return turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                         : Eigen::Matrix3d::Identity();
}

void read_neck(const Section& neck, Robot& robot) {
  robot.chest_height = neck.number("chest_height", {0.2, 2, "m"});
  hal::HeadKinematics& k = robot.mission.neck;
  k.chest_from_pan = offset(neck, "chest_from_pan");
  k.pan_from_tilt = offset(neck, "pan_from_tilt");
  k.tilt_from_camera = offset(neck, "tilt_from_camera");
  k.tilt_from_camera.linear() =
      turn_if(neck, "camera_turn_deg") *
      hal::body_from_optical(neck.number("camera_down_deg", {-60, 60, "deg"}) * kDegree);
  k.zero = {neck.number_or("pan_zero_deg", 0, {-20, 20, "deg"}) * kDegree,
            neck.number_or("tilt_zero_deg", 0, {-20, 20, "deg"}) * kDegree};
  robot.camera_time_offset = seconds(neck.number_or("camera_time_offset_ms", 0, {-100, 100, "ms"}) / 1000);
  hal::HeadLimits& limits = robot.mission.head;
  const auto pan = neck.numbers("pan_deg", 2, {-90, 90, "deg"}),
             tilt = neck.numbers("tilt_deg", 2, {-90, 90, "deg"});
  if (pan[0] >= pan[1]) neck.fail("pan_deg", "lowest and highest angle are the wrong way round");
  if (tilt[0] >= tilt[1]) neck.fail("tilt_deg", "lowest and highest angle are the wrong way round");
  limits.lower = {pan[0] * kDegree, tilt[0] * kDegree};
  limits.upper = {pan[1] * kDegree, tilt[1] * kDegree};
  limits.velocity = neck.number("velocity_deg_s", {1, 360, "deg/s"}) * kDegree;
  limits.acceleration = neck.number("acceleration_deg_s2", {1, 3600, "deg/s^2"}) * kDegree;
}

void read_step_over(const Section& section, nav::StepOverLimits& over) {
  over.height = section.number("height", {0, 0.14, "m"});
  over.forward = section.number_or("forward", over.forward, {0.05, 0.5, "m"});
  over.margin = section.number_or("margin", over.margin, {0, 0.1, "m"});
  over.duration = seconds(section.number_or("seconds", to_seconds(over.duration), {0.6, 1.55, "s"}));
  over.cost = section.number_or("cost_seconds", over.cost, {0, 100, "s"});
}

void read_gait(const Section& gait, nav::GaitLimits& limits) {
  limits.feet_apart = gait.number("feet_apart", {0.05, 0.45, "m"});
  limits.forward = gait.number("forward", {0.01, 0.5, "m"});
  limits.forward_on_arc = gait.number("forward_on_arc", {0.01, 0.5, "m"});
  limits.outward = gait.number("outward", {0.005, 0.2, "m"});
  limits.yaw = gait.number("yaw_deg", {0.5, 14, "deg"}) * kDegree;
  // In less than 0.6 s the preview sees too little of the way ahead to balance by, and feet land short.
  limits.step_duration = seconds(gait.number("step_seconds", {0.6, 1.55, "s"}));
  const auto sole = gait.numbers("sole", 2, {0.05, 0.5, "m"});
  limits.sole_length = sole[0];
  limits.sole_width = sole[1];
  limits.zmp_margin = gait.number_or("zmp_margin", limits.zmp_margin, {0, 0.1, "m"});
  if (const auto over = gait.section_if("step_over")) read_step_over(*over, limits.over);
  check(gait, limits);
}

void read_body(const Section& body, nav::BodyOutline& outline) {
  outline.half_depth = body.number("half_depth", {0.05, 1, "m"});
  outline.half_width = body.number("half_width", {0.05, 1, "m"});
  outline.sway = body.number("sway", {0, 0.2, "m"});
  outline.safety_margin = body.number("safety_margin", {0, 0.5, "m"});
  check(body, outline);
}

void read_map(const Section& map, Robot& robot) {
  robot.mapper.voxels.resolution = map.number("resolution", {0.01, 0.2, "m"});
  const auto height = map.numbers("height", 2, {-3, 5, "m"});
  if (height[0] >= height[1]) map.fail("height", "lowest and highest are the wrong way round");
  robot.map_height = {height[0], height[1]};
  robot.map_margin = map.number("margin", {0, 10, "m"});
  robot.mapper.window = map.number_or("window", 0, {0, 200, "m"});
  constexpr double kLeastWindow = 2;
  if (robot.mapper.window > 0 && robot.mapper.window < kLeastWindow)
    map.fail("window", fmt::format("{} m, expected 0 (the whole floor), or at least {} m",
                                   robot.mapper.window, kLeastWindow));
  robot.mapper.floor.floor_tolerance = map.number("floor_tolerance", {0, 0.5, "m"});
  robot.mapper.raised_floor.trip_height =
      map.number_or("trip_height", robot.mapper.raised_floor.trip_height, {0, 0.1, "m"});
  robot.mapper.floor.body_height = map.number("body_height", {0.2, 3, "m"});
  robot.mapper.voxels.obstacle_height = robot.mapper.floor.body_height;
  robot.mapper.start_area.radius = map.number("start_radius", {0, 3, "m"});
  robot.mapper.integration.supporters = map.integer("supporters", {0, 8});
  check(map, robot.mapper.floor);
}

void read_levelling(const Section& section, nav::LevellingConfig& config) {
  config.use = section.flag_or("use", config.use);
  nav::FloorFitConfig& fit = config.fit;
  fit.range = section.number_or("range", fit.range, {0.5, 20, "m"});
  fit.widest_tilt =
      section.number_or("widest_tilt_deg", fit.widest_tilt / kDegree, {0.1, 10, "deg"}) * kDegree;
  fit.greatest_height = section.number_or("greatest_height", fit.greatest_height, {0.005, 0.5, "m"});
  fit.least_points = section.integer_or("least_points", fit.least_points, {10, 1000000});
}

void read_localisation(const Section& section, runtime::LocalisationConfig& config) {
  config.use = section.flag_or("use", config.use);
  runtime::DriftConfig& drift = config.drift;
  drift.stride = section.number_or("stride", drift.stride, {0, 1});
  drift.swerve = section.number_or("swerve_deg_s", drift.swerve / kDegree, {0, 45, "deg/s"}) * kDegree;
  drift.shift = section.number_or("shift", drift.shift, {0, 1, "m"});
  drift.turn = section.number_or("turn_deg", drift.turn / kDegree, {0, 45, "deg"}) * kDegree;
  config.start_shift = section.number_or("start_shift", config.start_shift, {1e-3, 0.5, "m"});
  config.start_turn =
      section.number_or("start_turn_deg", config.start_turn / kDegree, {0.01, 20, "deg"}) * kDegree;
  config.lowest = section.number_or("lowest", config.lowest, {-1, 1, "m"});
  nav::LocaliseConfig& localise = config.localise;
  localise.shift_sigma = section.number_or("shift_sigma", localise.shift_sigma, {1e-4, 0.1, "m"});
  localise.turn_sigma =
      section.number_or("turn_sigma_deg", localise.turn_sigma / kDegree, {0.01, 5, "deg"}) * kDegree;
}

void read_planner(const Section& planner, nav::PlannerConfig& config) {
  const std::string unseen = planner.choice("unseen", {"blocked", "costly", "free"});
  config.unseen = unseen == "blocked"  ? nav::UnseenFloor::kBlocked
                  : unseen == "costly" ? nav::UnseenFloor::kCostly
                                       : nav::UnseenFloor::kFree;
  config.unseen_price = planner.number("unseen_price", {0, 100});
  config.near_price = planner.number("near_price", {0, 100});
  config.near_range = planner.number("near_range", {0.05, 3, "m"});
  config.mode_change = planner.number("mode_change_seconds", {0, 60, "s"});
  check(planner, config);
}

/// Returns what one view is taken to cover, where the file says so [rad].
std::optional<vision::FieldAngles> read_mission(const Section& mission, Robot& robot) {
  runtime::MissionConfig& config = robot.mission;
  config.frames_per_view = mission.integer("frames_per_view", {1, 20});
  config.gate.recent = seconds(mission.number("recent_seconds", {0.5, 600, "s"}));
  config.gate.blind_radius = mission.number("blind_radius", {0, 3, "m"});
  config.look_distance = mission.number("look_distance", {0.2, 5, "m"});
  config.goal_tolerance = mission.number("goal_tolerance", {0.01, 1, "m"});
  if (mission.choice_or("execution", "steps", {"steps", "orders"}) == "orders")
    config.execution = nav::Execution::kOrders;
  if (mission.choice_or("look_around", "gain", {"gain", "viewpoints"}) == "gain") {
    nav::NextViewConfig& next = config.next_view.emplace();
    next.space = {-robot.mapper.voxels.floor_band, robot.mapper.floor.body_height};
    next.least_gain = mission.number_or("least_gain", next.least_gain, {1e-6, 1000, "m^3"});
  } else if (mission.has("least_gain")) {
    mission.fail("least_gain", "only counts with look_around: gain");
  }
  robot.steps.max_map_age = seconds(mission.number("max_map_age_seconds", {0.1, 10, "s"}));
  const auto field = mission.numbers_if("look_around_field_deg", 2, {5, 170, "deg"});
  if (!field) return std::nullopt;
  return vision::FieldAngles{field->at(0) * kDegree, field->at(1) * kDegree};
}

/// What both cameras show at the distance that the head watches.
vision::FieldAngles field_of(const vision::StereoRig& rig, double look_distance) {
  return vision::field_angles(vision::Rectifier(rig).rig(), std::max(look_distance, rig.nearest));
}

/// The field in the left camera's frame.
vision::Polytope field_in_camera(const vision::StereoRig& rig) {
  const vision::Rectifier rectifier(rig);
  return vision::moved(vision::rig_polytope(rectifier.rig(), {rig.nearest, rig.farthest}),
                       rectifier.rectified_from_left().inverse());
}

void read_simulation(const Section& simulation, SimulationConfig& config) {
  config.frame_rate = simulation.number("frame_rate", {0.5, 100, "Hz"});
  const auto size = simulation.numbers("depth_image", 2, {16, 4096, "px"});
  config.depth_image = {static_cast<int>(size[0]), static_cast<int>(size[1])};
  config.depth_shift_sigma =
      simulation.number_or("depth_shift_sigma", config.depth_shift_sigma, {1e-4, 0.1, "m"});
  config.depth_turn_sigma =
      simulation.number_or("depth_turn_sigma_deg", config.depth_turn_sigma / kDegree, {0.01, 5, "deg"}) *
      kDegree;
  const Section body = simulation.section("body");
  config.body.com_height = body.number("com_height", {0.3, 2, "m"});
  config.body.lag = body.number("lag_ms", {0, 200, "ms"}) * 1e-3;
  config.body.landing_sigma = body.number("landing_mm", {0, 50, "mm"}) * 1e-3;
  config.body.landing_yaw_sigma = body.number("landing_deg", {0, 5, "deg"}) * kDegree;
  config.body.stride_scale = body.number("stride_scale", {0.5, 1.5});
  config.body.yaw_per_step = body.number("yaw_per_step_deg", {-2, 2, "deg"}) * kDegree;
  check(body, config.body);
  config.tilt_error = simulation.number_or("tilt_error_deg", 0, {-5, 5, "deg"}) * kDegree;
  const Section stage = simulation.section("stage_ms");
  const auto charge = [&](std::string_view key) {
    return seconds(stage.number(key, {0, 1000, "ms"}) * 1e-3);
  };
  config.charge = {charge("see"), charge("map"), charge("floor"), charge("plan")};
}

void read_runtime(const Section& section, runtime::LiveConfig& loops) {
  using Want = runtime::RealTime::Want;
  const std::string want = section.choice_or("real_time", "try", {"enforce", "try", "off"});
  loops.real_time.want = want == "enforce" ? Want::kEnforce : want == "try" ? Want::kTry : Want::kOff;
  if (section.has("bus_processor"))
    loops.real_time.bus_processor = section.integer("bus_processor", {0, 1023});
  loops.missed.most_missed =
      section.integer_or("most_missed", loops.missed.most_missed, {0, runtime::Cycle::kMostRemembered});
  loops.missed.within =
      seconds(section.number_or("missed_within_seconds", to_seconds(loops.missed.within), {0.1, 60, "s"}));
}

/// `fastest` is what the head may turn at [rad/s].
void read_homing(const Section& homing, double fastest, drivers::HomingConfig& config) {
  using Policy = drivers::HomingConfig::Policy;
  const bool moves = homing.flag_or("move", false);
  config.policy = moves ? Policy::kMove : Policy::kRequired;
  if (!homing.has("move")) return;  // whoever says how must say whether
  // What only counts with a move is checked all the same: it stands there for the day when it is allowed.
  config.method =
      moves ? homing.integer("method", {-128, 127}) : homing.integer_or("method", config.method, {-128, 127});
  if (homing.has("method") && config.method == 0)
    homing.fail("method", "0, expected one of the drive's manual, and 0 is none");
  const double most = std::round(fastest / kDegree * 1e6) / 1e6;  // as it was written
  const auto speed = [&](std::string_view key, double usual) {
    return kDegree *
           homing.number_or(key, std::min(usual / kDegree, most), {0.1, std::min(60.0, most), "deg/s"});
  };
  config.search_speed = speed("speed_deg_s", config.search_speed);
  config.zero_speed = speed("zero_speed_deg_s", config.zero_speed);
  config.acceleration =
      kDegree * homing.number_or("acceleration_deg_s2", config.acceleration / kDegree, {1, 1000, "deg/s^2"});
  config.longest = seconds(homing.number_or("longest_seconds", to_seconds(config.longest), {1, 600, "s"}));
}

void read_head(const Section& head, double fastest, HardwareConfig& config) {
  if (head.choice_or("set_points", "profile", {"profile", "cyclic"}) == "cyclic")
    config.set_points = drivers::SetPointMode::kCyclic;
  if (const auto homing = head.section_if("homing")) read_homing(*homing, fastest, config.homing);
}

void read_cameras(const Section& cameras, HardwareConfig& config) {
  config.left = cameras.text_or("left", config.left);
  config.right = cameras.text_or("right", config.right);
  if (!config.left.empty() && config.left == config.right)
    cameras.fail("right",
                 fmt::format("'{}' is the left eye as well, expected a device for each", config.right));
  if (cameras.has("format"))
    config.format = *drivers::image_format_named(cameras.choice("format", drivers::image_format_names()));
  config.rate = cameras.number_or("rate", config.rate, {1, 240, "Hz"});
  // No longer than the time from frame to frame, in whole hundredths that a person can read.
  const double longest_ms = std::floor(1e5 / config.rate) / 100;
  if (cameras.has("exposure_ms"))
    config.exposure = cameras.number("exposure_ms", {0.1, longest_ms, "ms"}) * 1e-3;
  if (cameras.has("gain")) config.gain = cameras.integer("gain", {0, 1e6});
  if (cameras.has("white_balance"))
    config.white_balance = cameras.integer("white_balance", {1000, 20000, "K"});
}

void read_hardware(const Section& hardware, double fastest, HardwareConfig& config) {
  config.place = hardware.place();
  config.bus = hardware.text_or("bus", config.bus);
  if (!config.bus.empty() && !is_can_transport(config.bus))
    hardware.fail("bus", fmt::format("'{}', expected one like {}", config.bus, can_transports()));
  if (const auto head = hardware.section_if("head")) read_head(*head, fastest, config);
  if (const auto cameras = hardware.section_if("cameras")) read_cameras(*cameras, config);
}

void read_recording(const Section& runtime, RecordingConfig& config) {
  config.black_box = runtime.text_or("black_box", config.black_box);
  config.black_box_bytes = static_cast<std::size_t>(runtime.integer_or("black_box_mb", 64, {4, 4096, "MiB"}))
                           << 20;
  config.file_bytes =
      static_cast<std::uint64_t>(runtime.integer_or("record_file_mb", 1024, {1, 1 << 20, "MiB"})) << 20;
}

/// As the file says; what it says elsewhere may not allow it.
void step_over_as_said(const Section& file, Robot& robot) {
  try {
    step_over(robot.mission.gait.over.height, robot);
  } catch (const InputError& fault) {
    file.section("gait").section("step_over").fail("height", fault.what());
  }
}

/// What the head sees through the rig, and where it looks to see all. `view`: what one view is taken to
/// cover, where the robot file says so.
void look_through(const std::filesystem::path& rig_file, const std::optional<vision::FieldAngles>& view,
                  Robot& robot) {
  runtime::MissionConfig& mission = robot.mission;
  try {
    mission.field = field_in_camera(robot.rig);
    mission.viewpoints =
        vision::viewpoints(mission.head, view ? *view : field_of(robot.rig, mission.look_distance));
  } catch (const InputError& fault) {
    throw InputError(fmt::format("{}: {}", config::one_line(rig_file.string(), 5000), fault.what()));
  }
}

/// Trunk and arms as one box, from the neck down to what no longer counts as floor.
nav::BodyBox whole_body(const Section& neck, const Robot& robot) {
  const nav::BodyOutline& outline = robot.mission.outline;
  const double depth = outline.half_depth + outline.sway, width = outline.half_width + outline.sway;
  const double top = robot.mission.neck.chest_from_pan.translation().z(),
               bottom = robot.mapper.floor.floor_tolerance - robot.chest_height;
  if (!(bottom < top)) neck.fail("chest_from_pan", "puts the neck below the floor, expected it above");
  return {{-depth, -width, bottom}, {depth, width, top}};
}

/// What a view shows of the robot itself: the boxes of its parts, or one that holds all of it.
std::vector<nav::BodyBox> own_body(const Section& file, const Robot& robot) {
  std::vector<nav::BodyBox> boxes;
  for (const Section& part : file.section("body").sections("parts")) {
    part.text("name");
    const auto centre = part.numbers("centre", 3, {-3, 3, "m"}),
               size = part.numbers("size", 3, {0.01, 3, "m"});
    const Eigen::Vector3d middle(centre[0], centre[1], centre[2]),
        half = Eigen::Vector3d(size[0], size[1], size[2]) / 2;
    boxes.push_back({middle - half, middle + half});
  }
  if (boxes.empty()) boxes.push_back(whole_body(file.section("neck"), robot));
  return boxes;
}

}  // namespace

std::filesystem::path default_robot_file() {
  namespace fs = std::filesystem;
  const fs::path name = "config/hrp2/robot.yaml";
  std::error_code ec;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ec).parent_path();
  const fs::path installed = folder.parent_path() / "share/headway" / name;
  // A build stands in TREE/build/PRESET.
  const fs::path of_tree = folder.parent_path().parent_path() / name;
  for (const fs::path& file : {installed, of_tree})
    if (fs::exists(file, ec)) return file;
  return name;
}

void step_over(double height, Robot& robot) {
  if (height > 0 && robot.mission.execution == nav::Execution::kOrders)
    throw InputError(
        "stepping over low obstacles: the control computer places the feet of orders itself and knows of "
        "none; expected execution: steps");
  if (height > 0 && robot.mapper.raised_floor.trip_height <= 0)
    throw InputError(
        "stepping over low obstacles: they are not looked for with trip_height: 0; expected more than 0 m");
  robot.mission.gait.over.height = height;
  robot.mission.gait.validate();
  robot.mapper.floor.step_over = height;
  robot.mapper.raised_floor.low_height = height;
  // Higher than that voxels tell.
  double& highest = robot.mapper.raised_floor.highest;
  if (height > 0) highest = std::max(highest, height + 2 * robot.mapper.voxels.resolution);
}

Robot read_robot(const std::filesystem::path& file, const std::optional<std::filesystem::path>& other_rig) {
  require_kind(file, FileKind::kRobot);
  const Section section = Section::load(file, "robot");
  Robot robot;
  robot.name = section.text("name");
  const std::filesystem::path named = section.path("rig"), rig = other_rig.value_or(named);
  robot.file = file;
  robot.rig_path = rig;
  std::error_code ec;
  if (!std::filesystem::exists(rig, ec))
    section.fail("rig",
                 fmt::format("{} is not there, expected a rig file, or a folder with one of each camera",
                             rig.string()));
  robot.vision.matcher.kind =
      vision::matcher_kind(section.choice_or("matcher", "census", vision::matcher_names()));
  read_neck(section.section("neck"), robot);
  read_gait(section.section("gait"), robot.mission.gait);
  const nav::WalkingConfig pattern = nav::walking_config(robot.mission.gait);
  robot.steps.known_after = seconds(pattern.known_after());
  robot.steps.shortest_step = seconds(pattern.shortest_step);
  read_body(section.section("body"), robot.mission.outline);
  read_map(section.section("map"), robot);
  if (const auto levelling = section.section_if("levelling")) read_levelling(*levelling, robot.levelling);
  if (const auto localisation = section.section_if("localisation"))
    read_localisation(*localisation, robot.localisation);
  read_planner(section.section("planner"), robot.mission.planner);
  const auto field = read_mission(section.section("mission"), robot);
  read_simulation(section.section("simulation"), robot.simulation);
  robot.hardware.place = file.string();
  if (const auto hardware = section.section_if("hardware"))
    read_hardware(*hardware, robot.mission.head.velocity, robot.hardware);
  if (const auto runtime = section.section_if("runtime")) {
    read_runtime(*runtime, robot.loops);
    read_recording(*runtime, robot.recording);
  }
  robot.mapper.integration.own_body = own_body(section, robot);
  step_over_as_said(section, robot);
  section.finish();
  robot.rig = vision::read_rig(rig);
  look_through(rig, field, robot);
  return robot;
}

}  // namespace headway::app
