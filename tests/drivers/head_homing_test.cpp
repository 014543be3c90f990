// Heads whose drives may not know where their joints are: a named state, and nothing moves unless the
// operator's configuration says so.
#include <ostream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/angle.h"
#include "hal/error.h"
#include "tests/drivers/head_bench.h"
#include "tests/drivers/noise.h"

namespace headway::drivers {

/// In the tests' names.
inline std::ostream& operator<<(std::ostream& out, SetPointMode mode) {
  return out << (mode == SetPointMode::kCyclic ? "Cyclic" : "Profile");
}

namespace {

using hal::HeadHealth;
using std::chrono::milliseconds;
using testing::HeadBench;
using Policy = HomingConfig::Policy;

HeadConfig with(Policy policy, SetPointMode mode = SetPointMode::kProfile) {
  HeadConfig config;
  config.set_points = mode;
  config.homing.policy = policy;
  config.homing.method = policy == Policy::kMove ? 17 : 0;
  config.homing.longest = seconds(3);
  return config;
}

class HeadHoming : public ::testing::TestWithParam<SetPointMode> {
 protected:
  static HeadConfig required() { return with(Policy::kRequired, GetParam()); }
  static HeadConfig moving() { return with(Policy::kMove, GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(BothModes, HeadHoming,
                         ::testing::Values(SetPointMode::kProfile, SetPointMode::kCyclic),
                         ::testing::PrintToStringParamName());

TEST_P(HeadHoming, OfDrivesThatKnowWhereTheyAreIsAskedAndNotDone) {
  for (const HeadConfig& config : {required(), moving()}) {
    HeadBench bench(config);
    bench.pan.position = 12345;
    ASSERT_TRUE(bench.start());
    bench.run(seconds(0.5));
    EXPECT_EQ(bench.pan.homings, 0);
    EXPECT_EQ(bench.pan.position, 12345);
    bench.head.command({0.3, 0.2});
    ASSERT_TRUE(bench.run_until([&] { return !bench.head.state().moving; }, seconds(3)));
    EXPECT_NEAR(bench.head.state().position.pan, 0.3, 2e-3);
  }
}

TEST_P(HeadHoming, IsNotBelievedOfADriveThatShowsAnotherMode) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until([&] { return bench.pan.homings == 1; }, seconds(3)));
  bench.to_head = [](hal::CanFrame& f) {
    // In profile position mode: a set-point acknowledged, and reached.
    if (f.id == 0x191) f.data[1] |= 0x14, f.data[2] = 1;
    return true;
  };
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(0.2)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kHomingFailed);
  EXPECT_EQ(bench.head.state().stamp, Time{});
}

TEST_P(HeadHoming, IsAskedOfADriveInItsModeOnly) {
  HeadBench bench(required());
  bench.pan.homed = false;
  int in_mode = 0;
  bench.to_head = [&](hal::CanFrame& f) {
    // It leaves the mode the moment it is there, before it could be asked.
    const bool enabled = f.id == 0x191 && (f.data[0] & 0x6F) == 0x27 && f.data[2] == 6;
    if (enabled && ++in_mode > 1) f.data[1] |= 0x10, f.data[2] = 1;
    return true;
  };
  hal::CanFrame attained{.id = 0x191, .dlc = 3, .data = {0x27, 0x10, 1}, .stamp = {}};
  const bool is_asked = bench.run_until(
      [&] {
        if (bench.head.pan().phase != DrivePhase::kHoming) return false;
        attained.stamp = bench.now;
        bench.head.receive(attained);
        return true;
      },
      seconds(3));
  ASSERT_TRUE(is_asked);
  EXPECT_FALSE(bench.run_until(HeadHealth::kReady, seconds(1)));
  EXPECT_TRUE(bench.run_until(HeadHealth::kFault, seconds(4)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kStateTimedOut);
}

TEST_P(HeadHoming, ThatIsMissingIsANamedStateAndTheHeadIsNotMoved) {
  HeadBench bench(required());
  bench.tilt.homed = false;
  bench.tilt.position = 4321;
  ASSERT_TRUE(bench.run_until(HeadHealth::kNotHomed, seconds(3)));
  EXPECT_EQ(bench.head.tilt().failure, DriveFailure::kNotHomed);
  EXPECT_EQ(bench.tilt.objects.count({0x6098, 0}), 0u) << "how to move is not even told";
  for (int i = 0; i < 400; ++i) {
    bench.head.command({0.5, 0.5});
    bench.cycle();
  }
  EXPECT_EQ(bench.head.state().health, HeadHealth::kNotHomed);
  EXPECT_EQ(bench.tilt.homings, 0);
  EXPECT_EQ(bench.tilt.position, 4321);
  EXPECT_EQ(bench.pan.position, 0);
}

TEST_P(HeadHoming, ThatWasDoneOtherwiseIsSeenWhenTheDriveBootsOrTheHeadIsRecovered) {
  HeadBench bench(required());
  bench.pan.homed = bench.tilt.homed = false;
  ASSERT_TRUE(bench.run_until(HeadHealth::kNotHomed, seconds(3)));
  bench.pan.homed = bench.tilt.homed = true;
  bench.pan.boot(bench.now);
  bench.run(seconds(2));
  EXPECT_EQ(bench.head.state().health, HeadHealth::kNotHomed) << "of the tilt drive";
  bench.head.recover();
  EXPECT_TRUE(bench.start());
}

TEST_P(HeadHoming, IsDoneWhereTheConfigurationSaysSoAndTheHeadStaysWhereThatEnds) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  bench.pan.home_reads = 1500;
  bench.tilt.position = -20000;
  ASSERT_TRUE(bench.start());
  bench.run(seconds(1));
  EXPECT_EQ(bench.pan.homings, 1);
  EXPECT_EQ(bench.tilt.homings, 0) << "knew where it was";
  EXPECT_EQ((bench.pan.objects[{0x6098, 0}]), 17u);
  EXPECT_EQ((bench.pan.objects[{0x6099, 1}]), 5730u);
  EXPECT_EQ((bench.pan.objects[{0x6099, 2}]), 1146u);
  EXPECT_EQ(bench.pan.position, 1500);
  EXPECT_EQ(bench.tilt.position, -20000);
  EXPECT_EQ(bench.pan.largest_start, 0);
}

TEST_P(HeadHoming, ThatFindsNothingIsAFaultAndStopped) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  bench.pan.never_finds_home = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(4)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kHomingFailed);
  bench.run(milliseconds(50));
  EXPECT_EQ(bench.pan.controlwords.back() & 0x110, 0x100) << "bit 4 was taken back, and it is halted";
}

TEST_P(HeadHoming, ThatTakesTooLongIsAFaultAndStopped) {
  HeadConfig config = moving();
  config.homing.longest = seconds(0.5);
  HeadBench bench(config);
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(3)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kHomingFailed);
  bench.run(seconds(2));
  EXPECT_FALSE(bench.pan.homed);
  EXPECT_EQ(bench.pan.controlwords.back() & 0x110, 0x100) << "bit 4 was taken back, and it is halted";
}

TEST_P(HeadHoming, IsNotBegunAgainAfterADrivesFaultUntilTheHeadIsRecovered) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until([&] { return bench.pan.homings == 1; }, seconds(3)));
  bench.run(milliseconds(200));
  bench.pan.fault();
  bench.run(seconds(3));
  EXPECT_EQ(bench.head.state().health, HeadHealth::kFault);
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kDriveFault);
  EXPECT_EQ(bench.pan.state, testing::ScriptedDrive::State::kFault) << "nobody has reset it";
  EXPECT_EQ(bench.pan.homings, 1);
  bench.head.recover();
  EXPECT_TRUE(bench.start());
  EXPECT_EQ(bench.pan.homings, 2);
}

TEST_P(HeadHoming, IsNotBegunAgainAfterAQuickStopUntilTheHeadIsRecovered) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until([&] { return bench.pan.homings == 1; }, seconds(3)));
  bench.run(milliseconds(200));
  bench.pan.quick_stop();
  bench.run(seconds(3));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kHomingFailed);
  EXPECT_EQ(bench.pan.homings, 1);
  bench.head.recover();
  EXPECT_TRUE(bench.start());
}

/// The robot may be walking.
TEST_P(HeadHoming, IsNotBegunByItselfWhenADriveThatWasAtHomeBootsInMidRun) {
  for (const bool knew : {true, false}) {
    HeadBench bench(moving());
    bench.pan.homed = knew;
    ASSERT_TRUE(bench.start());
    const int before = bench.pan.homings;
    bench.pan.homed = false;
    bench.pan.position = 2000;
    bench.pan.boot(bench.now);
    ASSERT_TRUE(bench.run_until(HeadHealth::kNotHomed, seconds(3)));
    bench.run(seconds(3));
    EXPECT_EQ(bench.pan.homings, before);
    EXPECT_EQ(bench.pan.position, 2000);
    bench.head.recover();
    EXPECT_TRUE(bench.start());
    EXPECT_EQ(bench.pan.homings, before + 1) << "somebody has asked for it";
  }
}

TEST_P(HeadHoming, IsBegunWhenADriveIsSwitchedOnAfterTheProgramWasStarted) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  bench.pan.mute_sdo = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(5)));
  bench.pan.mute_sdo = false;
  bench.pan.boot(bench.now);
  EXPECT_TRUE(bench.start());
  EXPECT_EQ(bench.pan.homings, 1);
}

TEST_P(HeadHoming, EndsInTimeAndHaltedEvenWhenTheDriveIsNotHeard) {
  HeadConfig config = moving();
  config.homing.longest = seconds(0.9);
  HeadBench bench(config);
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until([&] { return bench.pan.homings == 1; }, seconds(3)));
  bench.pan.mute_status = true;
  bench.run(milliseconds(300));
  EXPECT_TRUE(bench.pan.halted) << "while it is silent";
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(1)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kHomingFailed);
  bench.run(seconds(2));
  EXPECT_FALSE(bench.pan.homed);
  EXPECT_TRUE(bench.pan.halted);
}

TEST_P(HeadHoming, ThatFailedIsHaltedByTheNextOrderThatArrivesEvenWhenTheDriveIsNotHeard) {
  HeadConfig config = moving();
  config.homing.longest = seconds(0.5);
  HeadBench bench(config);
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until([&] { return bench.pan.homings == 1; }, seconds(3)));
  bench.pan.mute_status = true;
  bench.to_drives = [](hal::CanFrame& frame) { return frame.id != 0x211; };
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(1)));
  bench.to_drives = [](hal::CanFrame&) { return true; };
  bench.run(milliseconds(200));
  EXPECT_TRUE(bench.pan.halted);
  bench.run(seconds(2));
  EXPECT_FALSE(bench.pan.homed);
}

TEST_P(HeadHoming, MayTakeItsTimeHoweverLongTheOtherDriveWasAtFault) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until([&] { return bench.pan.homings == 1; }, seconds(3)));
  ASSERT_TRUE(bench.run_until([&] { return bench.head.tilt().phase == DrivePhase::kRunning; }, seconds(1)));
  bench.tilt.emergency(0x8611, bench.now);
  bench.run(seconds(5));
  ASSERT_EQ(bench.head.pan().phase, DrivePhase::kHoming);
  bench.head.recover();
  EXPECT_TRUE(bench.start());
  EXPECT_TRUE(bench.pan.homed);
}

TEST(HeadHomingCyclic, BeginsWhateverADriveReadsThatDoesNotKnowWhereItIs) {
  HeadBench bench(with(Policy::kMove, SetPointMode::kCyclic));
  bench.pan.homed = false;
  bench.pan.position = 1'000'000;
  bench.pan.home_reads = 1500;
  ASSERT_TRUE(bench.start());
  EXPECT_EQ(bench.pan.homings, 1);
  bench.run(seconds(0.5));
  EXPECT_EQ(bench.pan.position, 1500);
}

TEST(HeadHomingCyclic, IsOfNoUseWhereHomeLiesFarOutsideTheLimits) {
  HeadBench bench(with(Policy::kMove, SetPointMode::kCyclic));
  bench.pan.homed = false;
  bench.pan.home_reads = 50000;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(5)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kOutsideLimits);
  EXPECT_TRUE(bench.pan.homed);
}

/// The two frames of one SYNC may come in two cycles of the bus loop.
TEST(HeadHomingCyclic, TakesNoPositionFromBeforeItWasAtHome) {
  HeadBench bench(with(Policy::kMove, SetPointMode::kCyclic));
  bench.pan.homed = false;
  bench.pan.position = 1'000'000;
  bench.to_head = [&](hal::CanFrame& frame) {
    return frame.id != 0x291 || !bench.pan.homed || bench.head.pan().phase != DrivePhase::kHoming;
  };
  EXPECT_TRUE(bench.start());
}

TEST_P(HeadHoming, ComesBeforeAnyAngleOfTheHead) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  bench.pan.position = 1'000'000;
  bench.pan.home_reads = 1500;
  while (bench.head.state().health != HeadHealth::kReady) {
    bench.cycle();
    ASSERT_LT(bench.now, at_seconds(110));
    if (!bench.pan.homed) {
      ASSERT_EQ(bench.head.state().stamp, Time{}) << "that means nothing yet";
    }
  }
  EXPECT_GT(bench.head.state().stamp, bench.now - milliseconds(50));
  // It has lost its home in a reboot.
  bench.pan.homed = false;
  bench.pan.boot(bench.now);
  const Time last = bench.head.state().stamp;
  bench.run(seconds(3));
  ASSERT_EQ(bench.head.state().health, HeadHealth::kNotHomed);
  EXPECT_EQ(bench.head.state().stamp, last);
  EXPECT_NEAR(bench.head.state().position.pan, 1500 * kDegree / 1000, 1e-9);
}

TEST_P(HeadHoming, HaltsWhileTheOtherDriveIsAtFault) {
  HeadBench bench(moving());
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until([&] { return bench.pan.homings == 1; }, seconds(3)));
  ASSERT_TRUE(bench.run_until([&] { return bench.head.tilt().phase == DrivePhase::kRunning; }, seconds(1)));
  bench.tilt.emergency(0x8611, bench.now);
  bench.run(seconds(1.5));
  EXPECT_TRUE(bench.pan.halted);
  EXPECT_FALSE(bench.pan.homed);
  EXPECT_EQ(bench.head.state().health, HeadHealth::kFault);
}

RC_GTEST_PROP(HeadHomingProperty, NeverBeginsUnlessTheConfigurationSaysSo, ()) {
  const auto mode = *rc::gen::element(SetPointMode::kProfile, SetPointMode::kCyclic);
  HeadBench bench(with(*rc::gen::element(Policy::kNone, Policy::kRequired), mode));
  const std::uint32_t loss = *rc::gen::inRange(0u, 20u);
  testing::Noise noise(*rc::gen::inRange(1u, 1u << 30));
  bench.to_head = bench.to_drives = [&](hal::CanFrame&) { return noise.percent() >= loss; };
  for (int i = 0; i < 20; ++i) {
    bench.run(milliseconds(5 * (noise.percent() + 1)));
    if (noise.percent() < 20) bench.pan.boot(bench.now);
    if (noise.percent() < 20) bench.pan.homed = !bench.pan.homed;
    if (noise.percent() < 10) bench.tilt.quick_stop();
    if (noise.percent() < 20) bench.head.recover();
  }
  RC_ASSERT(bench.pan.homings + bench.tilt.homings == 0);
}

TEST(HomingConfig, RefusesToMoveInAWayThatNobodyNamed) {
  testing::ScriptedBus bus;
  const auto broken = [&](auto change) {
    HeadConfig config = with(Policy::kMove);
    change(config.homing);
    EXPECT_THROW((Cia402Head{bus, config}), InputError);
  };
  EXPECT_NO_THROW((Cia402Head{bus, with(Policy::kMove)}));
  broken([](HomingConfig& c) { c.method = 0; });
  broken([](HomingConfig& c) { c.method = 128; });
  broken([](HomingConfig& c) { c.search_speed = 0; });
  broken([](HomingConfig& c) { c.zero_speed = 2; });
  broken([](HomingConfig& c) { c.longest = {}; });
}

}  // namespace
}  // namespace headway::drivers
