#include "app/robot_file.h"

#include <algorithm>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/hardware.h"
#include "app/loop_configs.h"
#include "hal/angle.h"
#include "hal/error.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kRobot = source_dir() / "config/hrp2/robot.yaml";

/// Puts HRP-2's file into a folder, one line of it (the one that begins with `key`, in file order after
/// `section`) replaced by another; returns that line's number.
std::ptrdiff_t write_changed(const fs::path& folder, const std::string& section, const std::string& key,
                             const std::string& line) {
  fs::create_directory(folder / "rigs");
  fs::copy_file(kRobot.parent_path() / "rigs/bottom.yaml", folder / "rigs/bottom.yaml");
  std::string text = read_text(kRobot);
  const std::size_t begin = text.find(key, text.find(section));
  text.replace(begin, text.find('\n', begin) - begin, line);
  write_text(folder / "robot.yaml", text);
  return 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(begin), '\n');
}

/// What is said about the file so changed.
std::string fault_of(const std::string& section, const std::string& key, const std::string& line) {
  const TemporaryFolder folder;
  const auto number = write_changed(folder.path(), section, key, line);
  try {
    read_robot(folder / "robot.yaml");
  } catch (const InputError& e) {
    std::string what = e.what();
    const std::string place = (folder / "robot.yaml").string() + ":" + std::to_string(number) + ": ";
    return what.starts_with(place) ? what.substr(place.size()) : "elsewhere: " + what;
  }
  return "no fault";
}

/// Its hardware, as it is shipped: commented out.
std::string with_shipped_hardware() {
  std::string text = read_text(kRobot);
  const std::size_t begin = text.find("# hardware:");
  for (std::size_t line = begin; text.compare(line, 2, "# ") == 0; line = text.find('\n', line) + 1)
    text.erase(line, 2);
  return text;
}

TEST(RobotFile, ReadsTheShippedHardwareOnceItIsNoLongerCommentedOut) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "rigs");
  fs::copy_file(kRobot.parent_path() / "rigs/bottom.yaml", folder / "rigs/bottom.yaml");
  std::string text = with_shipped_hardware();
  write_text(folder / "robot.yaml", text);
  using Policy = drivers::HomingConfig::Policy;
  const Robot robot = read_robot(folder / "robot.yaml");
  EXPECT_EQ(robot.hardware.bus, "socketcan:can0");
  EXPECT_EQ(robot.hardware.homing.policy, Policy::kRequired);
  EXPECT_EQ(robot.hardware.homing.method, 17);
  const std::size_t move = text.find("move: false");
  text.replace(move, 11, "move: true");
  write_text(folder / "robot.yaml", text);
  EXPECT_EQ(read_robot(folder / "robot.yaml").hardware.homing.policy, Policy::kMove);
}

TEST(RobotFile, NamesLineAndKeyOfNumbersThatDoNotFitEachOther) {
  EXPECT_THAT(fault_of("gait:", "feet_apart", "feet_apart: 0.12"), HasSubstr("gait.feet_apart: is 0.12"));
  EXPECT_THAT(fault_of("gait:", "forward_on_arc", "forward_on_arc: 0.3"),
              HasSubstr("gait.forward_on_arc: is 0.30"));
  EXPECT_THAT(fault_of("map:", "body_height", "body_height: 0.2"), "no fault");
  EXPECT_THAT(fault_of("neck:", "chest_from_pan", "chest_from_pan: [0, 0, -1.5]"),
              HasSubstr("neck.chest_from_pan: puts the neck below the floor"));
  EXPECT_THAT(fault_of("simulation:", "stride_scale", "stride_scale: 1.5"),
              "simulation.body.stride_scale: must lie between 0.5 and 1.5");
}

TEST(RobotFile, SaysWhatMayBeSteppedOverAndHow) {
  const Robot plain = read_robot(kRobot);
  EXPECT_EQ(plain.mission.gait.over.height, 0);
  EXPECT_EQ(plain.mapper.floor.step_over, 0);
  const TemporaryFolder folder;
  write_changed(folder.path(), "gait:", "step_seconds:",
                "step_seconds: 0.8\n  step_over: {height: 0.08, forward: 0.4, margin: 0.02, seconds: 1.3, "
                "cost_seconds: 5}");
  const Robot over = read_robot(folder / "robot.yaml");
  const nav::StepOverLimits& limits = over.mission.gait.over;
  EXPECT_EQ(limits.height, 0.08);
  EXPECT_EQ(limits.forward, 0.4);
  EXPECT_EQ(limits.margin, 0.02);
  EXPECT_EQ(limits.duration, seconds(1.3));
  EXPECT_EQ(limits.cost, 5);
  EXPECT_EQ(over.mapper.floor.step_over, 0.08);
  EXPECT_EQ(over.mapper.raised_floor.low_height, 0.08);
  EXPECT_GE(over.mapper.raised_floor.highest, 0.08);
}

TEST(RobotFile, RefusesToStepOverWhatItsGaitOrItsMapCannot) {
  const auto fault = [](const std::string& over) {
    return fault_of("gait:", "step_seconds:", "step_seconds: 0.8\n  step_over: " + over);
  };
  EXPECT_THAT(fault("{height: 0.15}"), HasSubstr("height"));
  EXPECT_THAT(fault("{forward: 0.4}"), HasSubstr("height"));
  EXPECT_THAT(fault("{height: 0.06, forward: 0.1}"), HasSubstr("step_over: forward: is 0.10"));
  EXPECT_THAT(fault("{height: 0.06, seconds: 0.7}"), HasSubstr("step_over: seconds: is 0.70"));
  EXPECT_THAT(fault("{height: 0.06, wide: 1}"), HasSubstr("wide"));
  Robot orders = read_robot(kRobot);
  orders.mission.execution = nav::Execution::kOrders;
  EXPECT_THROW(step_over(0.06, orders), InputError);
  EXPECT_NO_THROW(step_over(0, orders));
  Robot heedless = read_robot(kRobot);
  heedless.mapper.raised_floor.trip_height = 0;
  EXPECT_THROW(step_over(0.06, heedless), InputError);
  Robot long_strides = read_robot(kRobot);
  long_strides.mission.gait.forward = 0.48;
  EXPECT_THROW(step_over(0.06, long_strides), InputError);
}

TEST(RobotFile, NamesTheKeyOfAStepOverThatSomethingElseInItForbids) {
  const TemporaryFolder folder;
  write_changed(folder.path(), "gait:", "step_seconds:", "step_seconds: 0.8\n  step_over: {height: 0.06}");
  const std::string text = read_text(folder / "robot.yaml");
  const auto fault = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    write_text(folder / "robot.yaml", other.replace(other.find(from), from.size(), to));
    try {
      read_robot(folder / "robot.yaml");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("no fault");
  };
  EXPECT_THAT(fault("\n  execution: steps", "\n  execution: orders"),
              HasSubstr("gait.step_over.height: stepping over low obstacles: the control computer places"));
  EXPECT_THAT(fault("trip_height: 0.025", "trip_height: 0"),
              HasSubstr("gait.step_over.height: stepping over low obstacles: they are not looked for"));
}

TEST(RobotFile, NamesTheFileOfARigThatLeavesNoCommonImage) {
  const TemporaryFolder folder;
  // Tall images, rolled against each other.
  write_text(folder / "tall.yaml",
             "name: tall\nsize: [96, 300]\nleft: {focal: [60, 60], centre: [47.5, 149.5]}\n"
             "right: {focal: [60, 60], centre: [47.5, 149.5]}\n"
             "right_from_left: {translation: [-0.0788, -0.0616, 0], rotation_deg: [0, 0, 38]}\n"
             "nearest: 0.5\nfarthest: 6\n");
  try {
    read_robot(kRobot, folder / "tall.yaml");
    FAIL() << "it is taken";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(),
                testing::StartsWith((folder / "tall.yaml").string() + ": rig tall: no common image"));
  }
}

/// HRP-2 with this hardware.
Robot with_hardware(const std::string& lines) {
  const TemporaryFolder folder;
  write_changed(folder.path(), "", "matcher:", "matcher: census\nhardware:\n" + lines);
  return read_robot(folder / "robot.yaml");
}

TEST(RobotFile, SaysHowTheHeadsDrivesAreLedAndWhetherTheyMayLookForHome) {
  using Policy = drivers::HomingConfig::Policy;
  const HardwareConfig plain = with_hardware("  bus: socketcan:can0").hardware;
  EXPECT_EQ(plain.set_points, drivers::SetPointMode::kProfile);
  EXPECT_EQ(plain.homing.policy, Policy::kNone);
  const Robot asked = with_hardware("  head: {set_points: cyclic, homing: {move: false}}");
  EXPECT_EQ(head_config(asked).set_points, drivers::SetPointMode::kCyclic);
  EXPECT_EQ(head_config(asked).homing.policy, Policy::kRequired);
  const Robot moved = with_hardware("  head: {homing: {move: true, method: 17, speed_deg_s: 10}}");
  EXPECT_EQ(head_config(moved).homing.policy, Policy::kMove);
  EXPECT_EQ(head_config(moved).homing.method, 17);
  EXPECT_NEAR(head_config(moved).homing.search_speed, 10 * kDegree, 1e-12);
  EXPECT_NO_THROW(head_config(moved).validate());
}

TEST(RobotFile, RefusesToLetTheHeadLookForHomeInAWayThatItDoesNotName) {
  EXPECT_THROW(with_hardware("  head: {homing: {move: true}}"), InputError);
  EXPECT_THROW(with_hardware("  head: {homing: {move: true, method: 0}}"), InputError);
  EXPECT_THROW(with_hardware("  head: {homing: {move: false, method: 0}}"), InputError)
      << "checked, for later";
  EXPECT_THROW(with_hardware("  head: {homing: {method: 17}}"), InputError) << "told how, and not whether";
  EXPECT_THROW(with_hardware("  head: {set_points: smooth}"), InputError);
}

TEST(RobotFile, SetsBothEyesAlikeByHand) {
  const Robot robot = with_hardware(
      "  bus: socketcan:can0\n  cameras:\n    left: /dev/video0\n    right: /dev/video2\n    exposure_ms: 8\n"
      "    gain: 20\n    white_balance: 4600");
  const drivers::StereoPairConfig pair = camera_pair(robot.hardware, robot.rig);
  for (const drivers::V4l2CameraConfig& eye : {pair.left, pair.right}) {
    EXPECT_EQ(eye.exposure, std::chrono::milliseconds(8));
    EXPECT_EQ(eye.gain, 20);
    EXPECT_EQ(eye.white_balance, 4600);
  }
  EXPECT_FALSE(camera_pair(with_hardware("  bus: socketcan:can0").hardware, robot.rig).left.white_balance);
}

/// What is said about this hardware: the line within it, from 1, and the rest.
std::string fault_of_hardware(const std::string& lines) {
  const TemporaryFolder folder;
  const auto first = 2 + write_changed(folder.path(), "", "matcher:", "matcher: census\nhardware:\n" + lines);
  const std::string file = (folder / "robot.yaml").string() + ":";
  try {
    read_robot(folder / "robot.yaml");
  } catch (const InputError& e) {
    const std::string what = e.what();
    if (!what.starts_with(file)) return "elsewhere: " + what;
    std::size_t digits = 0;
    const int line = std::stoi(what.substr(file.size()), &digits);
    return std::to_string(line - static_cast<int>(first) + 1) + what.substr(file.size() + digits);
  }
  return "no fault";
}

TEST(RobotFile, NamesLineKeyAndRemedyOfHardwareThatCannotBe) {
  struct Case {
    std::string lines;
    std::vector<std::string> said;
  };
  const std::string eyes = "  bus: socketcan:can0\n  cameras:\n    left: /dev/video0\n    ";
  for (const Case& c : std::vector<Case>{
           {"  bus: can0\n", {"1: hardware.bus: 'can0', expected one like socketcan:can0 or gs_usb:"}},
           {"  bus: 'socketcan:'\n", {"1: hardware.bus: 'socketcan:', expected one like"}},
           {eyes + "format: GRAY\n",
            {"4: hardware.cameras.format: 'GRAY' (did you mean 'GREY'?), expected one of: GREY, Y16, YUYV, "
             "NV12, MJPG"}},
           {eyes + "format: Z16\n", {"4: hardware.cameras.format: 'Z16'", "expected one of"}},
           {eyes + "right: /dev/video0\n", {"4: hardware.cameras.right: ", "expected a device for each"}},
           {eyes + "exposure: 8\n",
            {"4: hardware.cameras.exposure: is not a key here, did you mean 'exposure_ms'?"}},
           {eyes + "rate_hz: 15\n", {"4: hardware.cameras.rate_hz: ", "did you mean 'rate'?"}},
           {eyes + "rate: 15\n    exposure_ms: 80\n",
            {"5: hardware.cameras.exposure_ms: '80', expected a number from 0.1 to 66.66 ms"}},
           {eyes + "gain: much\n", {"4: hardware.cameras.gain: 'much', expected a whole number"}},
           {eyes + "white_balance: 100\n",
            {"4: hardware.cameras.white_balance: '100', expected a whole number from 1000 to 20000 K"}},
           {eyes + "right:\n", {"4: hardware.cameras.right: nothing, expected a text"}},
           {"  camera:\n    left: /dev/video0\n", {"1: hardware.camera: ", "did you mean 'cameras'?"}},
           {"  head: {homing: {move: true, method: 17, speed_deg_s: 59.9}}\n", {"no fault"}},
           {"  head: {homing: {move: true, method: 17, speed_deg_s: 61}}\n",
            {"1: hardware.head.homing.speed_deg_s: '61', expected a number from 0.1 to 60 deg/s"}},
           {"  head: {set_point: cyclic}\n", {"1: hardware.head.set_point: ", "did you mean 'set_points'?"}}})
    for (const std::string& part : c.said)
      EXPECT_THAT(fault_of_hardware(c.lines), HasSubstr(part)) << c.lines;
}

TEST(RobotFile, SaysHowUrgentTheLoopsAreAndHowManyCyclesMayBeMissed) {
  using Want = runtime::RealTime::Want;
  const runtime::LiveConfig plain = read_robot(kRobot).loops;
  EXPECT_EQ(plain.real_time.want, Want::kTry);
  EXPECT_FALSE(plain.real_time.bus_processor);
  EXPECT_EQ(plain.missed.most_missed, runtime::CycleLimits{}.most_missed);
  EXPECT_EQ(plain.missed.within, runtime::CycleLimits{}.within);
  const TemporaryFolder folder;
  write_changed(folder.path(), "runtime:", "real_time:", "real_time: enforce\n  bus_processor: 3");
  const runtime::LiveConfig strict = read_robot(folder / "robot.yaml").loops;
  EXPECT_EQ(strict.real_time.want, Want::kEnforce);
  EXPECT_EQ(strict.real_time.bus_processor, 3);
  EXPECT_THAT(fault_of("runtime:", "real_time:", "real_time: maybe"),
              HasSubstr("runtime.real_time: 'maybe', expected one of: enforce"));
  EXPECT_THAT(fault_of("runtime:", "most_missed:", "most_missed: 256"), HasSubstr("runtime.most_missed"));
  EXPECT_THAT(fault_of("runtime:", "missed_within_seconds:", "missed_within_seconds: 0"),
              HasSubstr("runtime.missed_within_seconds"));
}

TEST(RobotFile, SaysHowOdometryDrifts) {
  const runtime::LocalisationConfig localisation = read_robot(kRobot).localisation;
  EXPECT_TRUE(localisation.use);
  EXPECT_EQ(localisation.drift.stride, 0.03);
  EXPECT_NEAR(localisation.drift.swerve, 0.004, 0.0001);
  EXPECT_THAT(fault_of("localisation:", "use", "use: perhaps"), HasSubstr("localisation.use: 'perhaps'"));
  EXPECT_THAT(fault_of("localisation:", "shift_sigma", "shift_sigma: 0"),
              HasSubstr("localisation.shift_sigma: '0', expected"));
  EXPECT_THAT(fault_of("localisation:", "stride", "strides: 0.1"), HasSubstr("strides"));
}

TEST(RobotFile, SaysHowTheFloorTellsWhatTheHeadErrs) {
  const nav::LevellingConfig levelling = read_robot(kRobot).levelling;
  EXPECT_TRUE(levelling.use);
  EXPECT_NEAR(levelling.fit.widest_tilt, 0.0349, 0.0001);
  EXPECT_EQ(levelling.fit.greatest_height, 0.04);
  EXPECT_THAT(fault_of("levelling:", "range", "range: 0"), HasSubstr("levelling.range: '0', expected"));
  EXPECT_THAT(fault_of("levelling:", "least_points", "least_points: 1"),
              HasSubstr("levelling.least_points: "));
  EXPECT_THAT(fault_of("levelling:", "widest_tilt_deg", "widest_tilt: 2"), HasSubstr("widest_tilt_deg"))
      << "what was meant";
}

TEST(RobotFile, ListsThePartsOfTheBodyThatTheCamerasMaySee) {
  const std::vector<nav::BodyBox> whole = read_robot(kRobot).mapper.integration.own_body;
  ASSERT_EQ(whole.size(), 1U) << "one box, unless parts are listed";
  const TemporaryFolder folder;
  write_changed(folder.path(), "body:", "safety_margin",
                "safety_margin: 0.05\n  parts:\n"
                "    - {name: trunk, centre: [0, 0, 0.1], size: [0.4, 0.5, 0.6]}\n"
                "    - {name: left hand, centre: [0.3, 0.25, 0], size: [0.2, 0.1, 0.1]}");
  const std::vector<nav::BodyBox> parts = read_robot(folder / "robot.yaml").mapper.integration.own_body;
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_TRUE(parts[1].lowest.isApprox(Eigen::Vector3d(0.2, 0.2, -0.05), 1e-9));
  EXPECT_TRUE(parts[1].highest.isApprox(Eigen::Vector3d(0.4, 0.3, 0.05), 1e-9));
  const auto fault = [](const std::string& part) {
    return fault_of("body:", "sway", "sway: 0.03\n  parts: [{name: arm, centre: [0, 0, 0]" + part + "}]");
  };
  EXPECT_THAT(fault(""), HasSubstr("the key 'size' is missing"));
  EXPECT_THAT(fault(", size: [0, 1, 1]"), HasSubstr("size: '0', expected"));
  EXPECT_THAT(fault(", size: [1, 1, 1], frame: base"), HasSubstr("frame: is not a key here"));
}

TEST(RobotFile, SaysHowTheRobotLooksAround) {
  const Robot robot = read_robot(kRobot);
  ASSERT_TRUE(robot.mission.next_view);
  EXPECT_EQ(robot.mission.next_view->least_gain, 0.1);
  EXPECT_EQ(robot.mission.next_view->space.highest, robot.mapper.floor.body_height);
  EXPECT_TRUE(robot.mission.field.contains({0.1, 0, 2})) << "what the left camera and the right one see";
  EXPECT_FALSE(robot.mission.field.contains({0, 0, robot.rig.farthest + 0.1}));
  EXPECT_THAT(fault_of("mission:", "look_around", "look_around: here"), HasSubstr("mission.look_around: "));
  EXPECT_THAT(fault_of("mission:", "least_gain:", "least_gain: 0"), HasSubstr("mission.least_gain: "));
  EXPECT_THAT(fault_of("mission:", "look_around: gain", "look_around: viewpoints"),
              HasSubstr("least_gain: only"));
}

/// HRP-2 looks down over its own chest: `depth` ahead of the camera stands something flat.
nav::IntegrationStats look_down(double depth) {
  const Robot robot = read_robot(kRobot);
  runtime::MapperConfig config = robot.mapper;
  config.voxels.lowest = {-2, -2, -0.4};
  config.voxels.highest = {2, 2, 2.4};
  vision::RangeView view;
  view.camera = {64, 48, 400, 31.5, 23.5};
  view.near = 0.2, view.far = 3;
  view.depth.assign(64 * 48, static_cast<float>(depth));
  view.sigma_depth.assign(view.depth.size(), 0.005F);
  const Eigen::Isometry3d map_from_chest = Pose2{}.lifted(robot.chest_height);
  const Eigen::Isometry3d map_from_camera =
      map_from_chest * robot.mission.neck.chest_from_camera({0, 1.3963});
  return runtime::Mapper(config, {}).integrate(view, map_from_camera, map_from_chest, Time{});
}

TEST(RobotFile, TellsTheMapperWhatOfTheViewIsTheRobotItself) {
  const nav::IntegrationStats chest = look_down(0.6), floor = look_down(1.33);
  EXPECT_EQ(chest.hits + chest.misses, 0U);
  EXPECT_GT(chest.rejected, 0U);
  EXPECT_GT(floor.hits, 0U);
}

TEST(RobotFile, NamesTheLineOfARigThatIsNotThere) {
  EXPECT_THAT(fault_of("name:", "rig:", "rig: rigs/nowhere.yaml"), HasSubstr("nowhere.yaml is not there"));
}

TEST(DefaultRobotFile, IsTheTreesOwnWhereverTheProgramIsCalledFrom) {
  const TemporaryFolder folder;
  write_text(folder / "config/hrp2/robot.yaml", "name: of somebody else\n");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const std::filesystem::path file = default_robot_file();
  std::filesystem::current_path(before);
  EXPECT_EQ(file, source_dir() / "config/hrp2/robot.yaml");
}

}  // namespace
}  // namespace headway::app
