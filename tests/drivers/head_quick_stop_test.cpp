// Drives that stop by themselves: a fault with a name, left only when somebody recovers the head.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/head_bench.h"

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

}  // namespace
}  // namespace headway::drivers
