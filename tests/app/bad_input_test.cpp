// Broken files and arguments end with exit code 2 and one line that names the file; nothing crashes.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "app/commands.h"
#include "app/robot_file.h"
#include "hal/error.h"
#include "sim_hal/world_file.h"
#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

using test::Outcome, test::run_headway;

namespace fs = std::filesystem;
const fs::path kTree = source_dir();

std::vector<std::string> sim_of(const fs::path& world, const fs::path& out) {
  return {"sim",        world.string(), "--out",
          out.string(), "--robot",      (kTree / "config/hrp2/robot.yaml").string(),
          "--range"};
}

TEST(BadInput, AMissingWorldIsNamed) {
  const TemporaryFolder folder;
  const Outcome result = run_headway(sim_of(folder / "nowhere.yaml", folder / "out"));
  EXPECT_EQ(result.code, kBadInput);
  EXPECT_NE(result.error.find("nowhere.yaml"), std::string::npos) << result.error;
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << "one line";
}

TEST(BadInput, AMalformedWorldIsNamedWithLineAndKey) {
  const TemporaryFolder folder;
  std::string text = read_text(kTree / "config/worlds/lab.yaml");
  text.replace(text.find("seed:"), 5, "sede:");
  std::ofstream(folder / "lab.yaml") << text;
  const Outcome result = run_headway(sim_of(folder / "lab.yaml", folder / "out"));
  EXPECT_EQ(result.code, kBadInput);
  EXPECT_NE(result.error.find("lab.yaml:"), std::string::npos) << result.error;
  EXPECT_NE(result.error.find("sede"), std::string::npos) << result.error;
}

TEST(BadInput, AFloorTooLargeForTheMapIsNamedWithItsLine) {
  const TemporaryFolder folder;
  std::string text = read_text(kTree / "config/worlds/lab.yaml");
  const std::size_t floor = text.find("floor: {size: [7.2, 6.2]");
  text.replace(floor, 24, "floor: {size: [400, 400]");
  write_text(folder / "lab.yaml", text);
  const auto line =
      std::to_string(1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(floor), '\n'));
  const Outcome result = run_headway(sim_of(folder / "lab.yaml", folder / "out"));
  EXPECT_EQ(result.code, kBadInput);
  EXPECT_NE(result.error.find("lab.yaml:" + line + ": floor.size: "), std::string::npos) << result.error;
  EXPECT_NE(result.error.find("3e8 voxels"), std::string::npos) << result.error;
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << "one line";
}

TEST(BadInput, AGoalOutsideTheFloorIsRefused) {
  const TemporaryFolder folder;
  auto arguments = sim_of(kTree / "config/worlds/lab.yaml", folder / "out");
  arguments.insert(arguments.end(), {"--goal", "40,2"});
  const Outcome result = run_headway(arguments);
  EXPECT_EQ(result.code, kBadInput);
  EXPECT_NE(result.error.find("outside"), std::string::npos) << result.error;
}

TEST(BadInput, AGoalInAnObstacleIsRefused) {
  const TemporaryFolder folder;
  auto arguments = sim_of(kTree / "config/worlds/moving_box.yaml", folder / "out");
  arguments.insert(arguments.end(), {"--goal", "-0.6,1.65"});
  const Outcome result = run_headway(arguments);
  EXPECT_EQ(result.code, kBadInput);
  EXPECT_NE(result.error.find("--goal: (-0.60, 1.65) lies in an obstacle (chest)"), std::string::npos)
      << result.error;
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << "one line";
}

TEST(BadInput, AGoalInAnObstacleOrOffTheFloorIsNamedInItsFile) {
  const TemporaryFolder folder;
  const std::string text = read_text(kTree / "config/worlds/moving_box.yaml");
  const std::pair<const char*, const char*> all[] = {{"goal: [-0.6, 1.65]", "lies in an obstacle (chest)"},
                                                     {"goal: [9, 0]", "lies outside the floor"}};
  for (const auto& [goal, complaint] : all) {
    std::string changed = text;
    changed.replace(changed.find("goal: [1.8, 0]"), 14, goal);
    std::ofstream(folder / "w.yaml") << changed;
    const Outcome result = run_headway(sim_of(folder / "w.yaml", folder / "out"));
    EXPECT_EQ(result.code, kBadInput);
    EXPECT_NE(result.error.find("w.yaml:6: goal: "), std::string::npos) << result.error;
    EXPECT_NE(result.error.find(complaint), std::string::npos) << result.error;
  }
}

TEST(BadInput, NumbersThatAreNoneAreRefused) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const auto sim = sim_of(kTree / "config/worlds/lab.yaml", folder / "out");
  const auto with = [](std::vector<std::string> arguments, const std::vector<std::string>& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_headway(arguments);
  };
  for (const std::string bad : {"nan", "inf", "-nan"}) {
    EXPECT_EQ(with(sim, {"--longest", bad}).code, kBadInput);
    EXPECT_EQ(with(sim, {"--goal", "1,1," + bad}).code, kBadInput);
    EXPECT_EQ(with(sim, {"--goal=" + bad + ",1"}).code, kBadInput);
    EXPECT_EQ(with({"campaign", "--out", out}, {"--longest", bad}).code, kBadInput);
    for (const char* option : {"--resolution", "--near", "--far"})
      EXPECT_NE(with({"map", "--sequence", "x", "--out", out}, {option, bad}).error.find(option),
                std::string::npos);
    for (const char* option :
         {"--resolution", "--near", "--far", "--focal", "--baseline", "--cx", "--cy", "--offset"})
      EXPECT_NE(with({"reconstruct", "l", "r", "--out", out}, {option, bad}).error.find(option),
                std::string::npos);
  }
}

TEST(BadInput, StepsOverWhatTheRobotCannotStepOverAreRefused) {
  const TemporaryFolder folder;
  const auto complaint = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = sim_of(kTree / "config/worlds/step_over.yaml", folder / "out");
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome result = run_headway(arguments);
    EXPECT_EQ(result.code, kBadInput) << more.back();
    return result.error;
  };
  for (const char* bad : {"nan", "inf", "-0.01", "0.15", "high"})
    EXPECT_NE(complaint({std::string("--step-over=") + bad}).find("--step-over"), std::string::npos) << bad;
  EXPECT_NE(complaint({"--step-over", "0.06", "--execution", "orders"}).find("expected execution: steps"),
            std::string::npos);

  std::filesystem::copy(kTree / "config/hrp2/rigs", folder / "rigs");
  std::string text = read_text(kTree / "config/hrp2/robot.yaml");
  text.replace(text.find("step_seconds: 0.8"), 17, "step_seconds: 0.8\n  step_over: {height: 0.06}");
  std::ofstream(folder / "robot.yaml") << text;
  const Outcome result = run_headway({"sim", (kTree / "config/worlds/step_over.yaml").string(), "--out",
                                      (folder / "out").string(), "--robot", (folder / "robot.yaml").string(),
                                      "--execution", "orders"});
  EXPECT_EQ(result.code, kBadInput) << "what the robot file asks for counts as well";
  EXPECT_NE(result.error.find("expected execution: steps"), std::string::npos) << result.error;
}

TEST(BadInput, StepsFasterThanTheRobotCanWalkAreRefused) {
  const TemporaryFolder folder;
  std::filesystem::copy(kTree / "config/hrp2/rigs", folder / "rigs");
  std::string text = read_text(kTree / "config/hrp2/robot.yaml");
  text.replace(text.find("step_seconds: 0.8"), 17, "step_seconds: 0.5");
  std::ofstream(folder / "robot.yaml") << text;
  try {
    read_robot(folder / "robot.yaml");
    FAIL() << "was read";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("step_seconds"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("0.6"), std::string::npos) << e.what();
  }
}

TEST(BadInput, ACampaignOfNoWorldIsRefused) {
  const TemporaryFolder folder;
  const Outcome result =
      run_headway({"campaign", "--worlds", "3", "--only", "3", "--out", (folder / "out").string()});
  EXPECT_EQ(result.code, kBadInput);
  EXPECT_NE(result.error.find("--only: is 3, expected 0 to 2"), std::string::npos) << result.error;
}

/// Exit code 2 and one line, of which this is a part.
testing::AssertionResult refuses(const std::vector<std::string>& arguments, const std::string& part) {
  const Outcome result = run_headway(arguments);
  if (result.code != kBadInput) return testing::AssertionFailure() << "exit code " << result.code;
  if (!result.error.starts_with("headway: ") || result.error.find('\n') != result.error.size() - 1 ||
      result.error.find(part) == std::string::npos)
    return testing::AssertionFailure() << result.error;
  return testing::AssertionSuccess();
}

/// As a tired engineer types them.
TEST(BadInput, ArgumentsOfTheCommandsForHardwareAreToldWithWhatWasExpected) {
  const std::string robot = (kTree / "config/hrp2/robot.yaml").string();
  const std::string world = (kTree / "config/worlds/lab.yaml").string();
  EXPECT_TRUE(refuses({"run"}, "run: robot is required: Robot file, e.g. config/hrp2/robot.yaml; see"));
  EXPECT_TRUE(refuses({"run", "--robot", robot}, "run: --robot is no option, expected one of: "));
  EXPECT_TRUE(refuses({"run", robot, "-goal", "1,0"}, "run: -goal is no option; did you mean --goal?; see"));
  EXPECT_TRUE(refuses({"run", robot, "--goal", "1"}, "run: --goal: too few values, expected X,Y[,YAW] ("));
  EXPECT_TRUE(
      refuses({"run", robot, "--goal", "1,0,90,4"}, "run: --goal: too many values, expected X,Y[,YAW]"));
  EXPECT_TRUE(refuses({"run", robot, "--goal", "1,O"}, "run: --goal: is O, expected a number"));
  EXPECT_TRUE(refuses({"run", robot, "--goal"}, "run: --goal: "));
  EXPECT_TRUE(refuses({"run", robot, "--floor", "20"}, "run: --floor: too few values, expected X,Y"));
  EXPECT_TRUE(
      refuses({"run", robot, "--bus", "can0"}, "run: --bus: is 'can0', expected one like socketcan:can0"));
  EXPECT_TRUE(refuses({"run", robot, "extra"}, "run: 'extra' is too much, expected no more than options: "));
  EXPECT_TRUE(refuses({"run", robot}, "robot.yaml: hardware.bus: is missing, expected the robot's CAN bus"));
  EXPECT_TRUE(
      refuses({"run", world, "--goal", "1,0"}, "lab.yaml: looks like a world, expected a robot file"));
  EXPECT_TRUE(refuses({"node", robot, "--bus", "socketcan:vcan0"}, "node: --world is required: World file"));
  EXPECT_TRUE(
      refuses({"node", robot, "--world", world, "--bus", "vcan0"}, "node: --bus: is 'vcan0', expected"));
  EXPECT_TRUE(refuses({"node", robot, "--world", world, "--bus", "socketcan:vcan0", "--left", "x"},
                      "node: --left or --right is missing, expected both or neither"));
  for (const char* same : {"e", "./e", "nowhere/../e"})
    EXPECT_TRUE(
        refuses({"node", robot, "--world", world, "--bus", "socketcan:vcan0", "--left", "e", "--right", same},
                "is the left eye as well, expected a pipe for each"))
        << same;
  EXPECT_TRUE(
      refuses({"node", robot, "--camera", "3"}, "node: --camera is no option; did you mean --camera-delay?"));
  for (const char* command : {"run", "doctor"})
    EXPECT_TRUE(
        refuses({command, robot, "--bus", "socketcan:can0", "--left", "l", "--right", "r", "--slower", "4"},
                "--slower: would stretch every time-out of a robot on socketcan:can0"));
  EXPECT_TRUE(refuses({"doctor", robot, "--json"}, "doctor: --json: a value is missing, expected "));
  EXPECT_TRUE(refuses({"doctor", robot, "--bus", "can0"}, "doctor: --bus: is 'can0', expected one like"));
  EXPECT_TRUE(
      refuses({"can", "dump", "can0"}, "can dump: 'can0' is too much, expected no more than options: "));
  EXPECT_TRUE(refuses({"can", "dmup"}, "can: 'dmup' is no command; did you mean dump?; see"));
  EXPECT_TRUE(
      refuses({"can", "dump", "--bus", "gs_usb:"}, "can dump: --bus: is 'gs_usb:', expected one like"));
  EXPECT_TRUE(refuses({"camera", "show"}, "camera show: device is required: The camera, or the left"));
  EXPECT_TRUE(refuses({"camera", "show", "a", "b", "c"}, "camera show: "));
  EXPECT_TRUE(refuses({"camera", "show", "a", "--size", "640"},
                      "camera show: --size: too few values, expected WIDTHxHEIGHT"));
  EXPECT_TRUE(refuses({"camera", "show", "a", "--size", "640xx"}, "camera show: --size: "));
  EXPECT_TRUE(refuses({"camera", "show", "a", "--exposure_ms", "8"}, "did you mean --exposure?"));
  EXPECT_TRUE(
      refuses({"camera", "show", "a", "--format", "MJPEG"}, "camera show: --format: MJPEG not in {GREY,"));
  EXPECT_TRUE(refuses({"doctr", robot}, "'doctr' is no command; did you mean doctor?; see 'headway --help'"));
}

TEST(BadInput, ASizeMayBeWrittenAsPeopleDo) {
  for (const std::vector<std::string>& size : {std::vector<std::string>{"640x480"}, {"640", "480"}}) {
    std::vector<std::string> arguments{"camera", "show", "/nowhere/video0", "--format", "grey", "--size"};
    arguments.insert(arguments.end(), size.begin(), size.end());
    EXPECT_TRUE(refuses(arguments, "camera /nowhere/video0: is not there")) << size.front();
  }
}

TEST(BadInput, ArgumentsThatAreNoneAreToldInOneLineWithTheWayToHelp) {
  EXPECT_TRUE(refuses({}, "no command, expected one of: sim, campaign, "));
  EXPECT_TRUE(refuses({"fly"}, "'fly' is no command, expected one of: sim, "));
  EXPECT_TRUE(refuses({"--fly"}, "'--fly' is no command"));
  EXPECT_TRUE(refuses({"rig"}, "rig: no command, expected one of: convert; see 'headway rig --help'"));
  EXPECT_TRUE(refuses({"map"}, "map: --sequence is required: "));
  EXPECT_TRUE(refuses({"map", "--near", "1", "convert", "a.ot", "b.ot"}, "--near excludes convert"));
  EXPECT_TRUE(refuses({"rig", "convert"}, "rig convert: from is required: "));
  EXPECT_TRUE(refuses({"sim"}, "sim: world is required: "));
  EXPECT_TRUE(refuses({"sim", "w", "--out", "o", "--fly"}, "sim: --fly is no option, expected one of: "));
  EXPECT_TRUE(refuses({"sim", "w", "--outt", "o"}, "sim: --outt is no option; did you mean --out?; see"));
  EXPECT_TRUE(refuses({"rig", "convert", "--nmae=a"}, "--nmae is no option; did you mean --name?; see"));
  EXPECT_TRUE(refuses({"campaign", "--worlds", "-3"}, "campaign: --worlds: "));
  EXPECT_TRUE(
      refuses({"map", "--sequence", "s", "--out", "o", "--matcher", "a\nb"}, "map: --matcher: a b not in"));
  for (const std::string seed : {"-1", "1.5", "", "99999999999999999999"}) {
    EXPECT_TRUE(refuses({"sim", "w", "--out", "o", "--seed=" + seed}, "sim: --seed"));
    EXPECT_TRUE(refuses({"campaign", "--seed=" + seed}, "campaign: --seed"));
  }
  EXPECT_EQ(run_headway({"--help"}).code, kSuccess);
  EXPECT_EQ(run_headway({"sim", "--help"}).code, kSuccess);
}

TEST(BadInput, AFileOfAnotherKindIsCalledWhatItIs) {
  const std::string robot = (kTree / "config/hrp2/robot.yaml").string(),
                    world = (kTree / "config/worlds/lab.yaml").string();
  EXPECT_TRUE(refuses({"sim", robot, "--out", "o", "--robot", robot},
                      "robot.yaml: looks like a robot file, expected a world"));
  EXPECT_TRUE(refuses({"sim", world, "--out", "o", "--robot", world},
                      "lab.yaml: looks like a world, expected a robot file"));
  EXPECT_TRUE(
      refuses({"sim", (kTree / "config/hrp2/rigs/bottom.yaml").string(), "--out", "o", "--robot", robot},
              "bottom.yaml: looks like a rig, expected a world"));
}

TEST(BadInput, AnOutFolderWithoutANameIsRefused) {
  auto arguments = sim_of(kTree / "config/worlds/lab.yaml", "");
  EXPECT_TRUE(refuses(arguments, "--out: is empty, expected a folder to write into"));
}

TEST(BadInput, AnOutFolderThatCannotBeMadeIsNamed) {
  const TemporaryFolder folder;
  std::ofstream(folder / "file") << "not a folder";
  const Outcome result = run_headway(sim_of(kTree / "config/worlds/lab.yaml", folder / "file/out"));
  EXPECT_EQ(result.code, kBadInput);
  EXPECT_NE(result.error.find("file"), std::string::npos) << result.error;
}

TEST(BadInput, AnOutFolderWhoseNameIsTooLongIsNamed) {
  const TemporaryFolder folder;
  const Outcome result =
      run_headway(sim_of(kTree / "config/worlds/lab.yaml", folder / std::string(300, 'x')));
  EXPECT_EQ(result.code, kBadInput);
  EXPECT_NE(result.error.find("xxx: cannot be made the folder that --out names"), std::string::npos)
      << result.error;
}

/// Cuts, overwrites, doubles or swaps pieces of a text.
std::string mutated(std::string text) {
  const int edits = *rc::gen::inRange(1, 6);
  for (int i = 0; i < edits && !text.empty(); ++i) {
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    switch (*rc::gen::inRange(0, 5)) {
      case 0:
        text.resize(at);
        break;
      case 1:
        text[at] = *rc::gen::arbitrary<char>();
        break;
      case 2:
        text.insert(at, *rc::gen::elementOf(
                            std::vector<std::string>{"-", ": ", "\n", "1e999", "[", "{", "&a ", "*a"}));
        break;
      case 3:
        text.erase(at, *rc::gen::inRange<std::size_t>(1, 40));
        break;
      default:
        text.insert(at, text.substr(*rc::gen::inRange<std::size_t>(0, text.size()), 60));
    }
  }
  return text;
}

RC_GTEST_PROP(BadInput, MutatedWorldsAreReadOrRefusedButNeverCrash, ()) {
  static const std::string kText = read_text(kTree / "config/worlds/lab.yaml");
  try {
    sim::world_from(config::Section::parse(mutated(kText), "lab.yaml"));
  } catch (const InputError& e) {
    RC_ASSERT(std::string(e.what()).find("lab.yaml") != std::string::npos);
  }
}

RC_GTEST_PROP(BadInput, MutatedRobotsAreReadOrRefusedButNeverCrash, ()) {
  static const std::string kText = read_text(kTree / "config/hrp2/robot.yaml");
  const TemporaryFolder folder;
  fs::create_directory(folder / "rigs");
  fs::copy_file(kTree / "config/hrp2/rigs/bottom.yaml", folder / "rigs/bottom.yaml");
  std::ofstream(folder / "robot.yaml") << mutated(kText);
  try {
    read_robot(folder / "robot.yaml");
  } catch (const InputError& e) {
    const std::string what = e.what();
    RC_ASSERT(what.find("robot.yaml:") != std::string::npos ||
              what.find("bottom.yaml:") != std::string::npos);
  }
}

}  // namespace
}  // namespace headway::app
