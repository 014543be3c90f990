// Drives that stop by themselves: a fault with a name, left only when somebody recovers the head.
#include <algorithm>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/cia402.h"
#include "tests/drivers/head_bench.h"
#include "tests/drivers/noise.h"

namespace headway::drivers {
namespace {

using hal::HeadHealth;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using testing::HeadBench;
using testing::ScriptedDrive;
using State = ScriptedDrive::State;

class QuickStoppedHead : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(bench.start()); }
  void fault_and_check(DriveFailure why) {
    EXPECT_EQ(bench.head.state().health, HeadHealth::kFault);
    EXPECT_EQ(bench.head.pan().failure, why);
  }
  HeadBench bench;
};

TEST_F(QuickStoppedHead, KeepsItsNameWhenTheDriveFaultsMeanwhile) {
  bench.pan.quick_stop();
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(1)));
  bench.pan.fault();
  bench.run(seconds(2));
  fault_and_check(DriveFailure::kQuickStopped);
  EXPECT_EQ(bench.pan.state, State::kFault) << "nobody has reset it";
  bench.head.recover();
  EXPECT_TRUE(bench.start());
}

TEST_F(QuickStoppedHead, IsAFaultThatIsCountedAndLeftOnlyWhenRecovered) {
  bench.pan.states.clear();
  bench.pan.quick_stop();
  bench.run(seconds(3));
  fault_and_check(DriveFailure::kQuickStopped);
  EXPECT_EQ(bench.head.pan().quick_stops, 1u);
  EXPECT_TRUE(bench.tilt.halted);
  EXPECT_THAT(bench.pan.states, ElementsAre(State::kQuickStop));
  bench.head.recover();
  EXPECT_TRUE(bench.start());
  EXPECT_THAT(bench.pan.states, ElementsAre(State::kQuickStop, State::kEnabled)) << "transition 16";
  EXPECT_EQ(bench.head.pan().quick_stops, 1u);
}

TEST_F(QuickStoppedHead, IsLeftThroughDisabledWhereTheDriveKnowsNoTransition16) {
  bench.pan.knows_transition_16 = false;
  bench.pan.states.clear();
  bench.pan.quick_stop();
  bench.run(milliseconds(60));
  bench.head.recover();
  EXPECT_TRUE(bench.start());
  EXPECT_THAT(bench.pan.states,
              ElementsAre(State::kQuickStop, State::kDisabled, State::kReady, State::kOn, State::kEnabled));
}

TEST_F(QuickStoppedHead, IsNotToldToGoOnWhileItCannotBeSeen) {
  bench.pan.mute_status = true;
  bench.run(milliseconds(60));
  bench.pan.states.clear();
  bench.pan.quick_stop();
  bench.head.command({0.3, 0});
  bench.run(seconds(1));
  EXPECT_THAT(bench.pan.states, ElementsAre(State::kQuickStop));
  bench.pan.mute_status = false;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, milliseconds(50)));
  fault_and_check(DriveFailure::kQuickStopped);
}

TEST_F(QuickStoppedHead, StaysAFaultWhenTheDriveHasLeftOperationalToo) {
  bench.pan.quick_stop();
  bench.pan.operational = false;
  bench.run(seconds(3));
  fault_and_check(DriveFailure::kQuickStopped);
  EXPECT_EQ(bench.pan.state, State::kQuickStop);
  bench.head.recover();
  EXPECT_TRUE(bench.start());
}

TEST(QuickStoppedCyclicHead, IsAFaultInMidTurnAndStaysWhereItStopped) {
  HeadConfig config;
  config.set_points = SetPointMode::kCyclic;
  HeadBench bench(config);
  ASSERT_TRUE(bench.start());
  bench.head.command({0.7, 0});
  bench.run(milliseconds(300));
  bench.pan.quick_stop();
  const auto stopped = bench.pan.position;
  bench.run(seconds(2));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kQuickStopped);
  EXPECT_EQ(bench.head.pan().quick_stops, 1u);
  EXPECT_EQ(bench.pan.position, stopped);
}

TEST(QuickStoppedCyclicHead, GoesOnFromRestWhenOnlyItsStatusWasLostForAMoment) {
  HeadConfig config;
  config.set_points = SetPointMode::kCyclic;
  HeadBench bench(config);
  ASSERT_TRUE(bench.start());
  bench.head.command({0.7, 0});
  bench.run(milliseconds(300));
  bench.pan.mute_status = true;
  bench.run(milliseconds(90));
  bench.pan.mute_status = false;
  bench.pan.cyclic_targets.clear();
  bench.run(seconds(2));
  EXPECT_LT(bench.pan.cyclic_targets[1] - bench.pan.cyclic_targets[0], 200) << "it begins slowly";
  EXPECT_EQ(bench.pan.position, 40107);
}

// --- properties ---

HeadConfig drawn_config() {
  using Policy = HomingConfig::Policy;
  HeadConfig config;
  config.set_points = *rc::gen::element(SetPointMode::kProfile, SetPointMode::kCyclic);
  config.homing.policy = *rc::gen::element(Policy::kNone, Policy::kRequired, Policy::kMove);
  config.homing.method = config.homing.policy == Policy::kMove ? 17 : 0;
  return config;
}

/// As when a plug is pulled: neither side hears the other, and whoever leads the head goes on as before.
RC_GTEST_PROP(QuickStoppedHeadProperty, StandsUntilRecoveredAfterBothSidesWereNotHeard, ()) {
  HeadBench bench(drawn_config());
  RC_ASSERT(bench.start());
  const auto turn = [&](Duration time) {
    return [&bench, end = bench.now + time] {
      bench.head.command({0.7, 0});
      return bench.now >= end;
    };
  };
  bench.run_until(turn(milliseconds(5 * *rc::gen::inRange(1, 120))), seconds(1));
  bench.to_head = bench.to_drives = [](hal::CanFrame&) { return false; };
  const Duration away = milliseconds(5 * *rc::gen::inRange(70, 400));
  bench.run_until(turn(away), seconds(3));
  RC_ASSERT(bench.pan.state == State::kQuickStop && bench.tilt.state == State::kQuickStop);
  const std::int32_t stopped = bench.pan.position;
  bench.to_head = bench.to_drives = [](hal::CanFrame&) { return true; };
  bench.run_until(turn(seconds(4)), seconds(5));
  RC_ASSERT(bench.head.state().health == HeadHealth::kFault);
  RC_ASSERT(bench.head.pan().failure == DriveFailure::kQuickStopped);
  RC_ASSERT(bench.pan.state == State::kQuickStop && bench.tilt.state == State::kQuickStop);
  RC_ASSERT(bench.pan.position == stopped);
  bench.head.recover();
  RC_ASSERT(bench.start());
  bench.run_until(turn(seconds(3)), seconds(4));
  RC_ASSERT(bench.pan.position == 40107);
}

bool would_end_a_quick_stop(const hal::CanFrame& frame) {
  using namespace hal::cia402;
  const auto word = static_cast<std::uint16_t>(frame.data[0] | (frame.data[1] << 8));
  return after(hal::cia402::State::kQuickStopActive, command_of(word)) !=
         hal::cia402::State::kQuickStopActive;
}

RC_GTEST_PROP(QuickStoppedHeadProperty, IsNotToldToGoOnWhileItsStatusIsOlderThan50Ms, ()) {
  HeadBench bench(drawn_config());
  testing::Noise noise(*rc::gen::inRange(1u, 1u << 30));
  bench.pan.homed = noise.percent() < 50;
  std::map<std::uint32_t, Time> status;
  const std::uint32_t loss = *rc::gen::inRange(0u, 20u);
  bench.to_head = [&](hal::CanFrame& frame) {
    const bool arrives = noise.percent() >= loss;
    if (arrives && (frame.id == 0x191 || frame.id == 0x192)) status[frame.id & 0x0F] = frame.stamp;
    return arrives;
  };
  bench.to_drives = [&](hal::CanFrame& frame) {
    if ((frame.id == 0x211 || frame.id == 0x212) && would_end_a_quick_stop(frame))
      RC_ASSERT(bench.now - status[frame.id & 0x0F] <= milliseconds(50));
    return noise.percent() >= loss;
  };
  bench.run(milliseconds(5 * (noise.percent() + 1)));
  for (int i = 0; i < 20; ++i) {
    ScriptedDrive& drive = noise.percent() < 50 ? bench.pan : bench.tilt;
    if (noise.percent() < 50) drive.mute_status = !drive.mute_status;
    if (noise.percent() < 20) drive.quick_stop();
    if (noise.percent() < 10) drive.boot(bench.now);
    if (noise.percent() < 10) drive.fault();
    if (noise.percent() < 20) bench.head.recover();
    bench.head.command({0.01 * noise.percent(), 0});
    bench.run(milliseconds(5 * (noise.percent() + 1)));
  }
}

TEST(QuickStoppedHomingHead, StopsWhenItCannotBeSeenAndIsBegunAgainOnlyWhenRecovered) {
  HeadConfig config;
  config.homing = {.policy = HomingConfig::Policy::kMove, .method = 17};
  HeadBench bench(config);
  bench.pan.homed = false;
  ASSERT_TRUE(bench.run_until([&] { return bench.pan.homings == 1; }, seconds(3)));
  bench.run(milliseconds(200));
  bench.pan.mute_status = true;
  bench.run(milliseconds(80));
  EXPECT_EQ(bench.pan.state, State::kQuickStop);
  bench.pan.mute_status = false;
  bench.run(seconds(3));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kHomingFailed);
  EXPECT_EQ(bench.pan.homings, 1);
  bench.head.recover();
  EXPECT_TRUE(bench.start());
}

}  // namespace
}  // namespace headway::drivers
