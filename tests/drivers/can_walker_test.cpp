#include "drivers/can_walker.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/drivers/noise.h"
#include "tests/drivers/walker_bench.h"

namespace headway::drivers {
namespace {

using hal::StepReject;
using hal::WalkerHealth;
using hal::WalkRequest;
using std::chrono::milliseconds;
using testing::step_of;
using testing::WalkerBench;
using Status = hal::bus::WalkStatus;

class Walking : public ::testing::Test {
 protected:
  void SetUp() override {
    bench.run(milliseconds(100));
    ASSERT_TRUE(bench.begin(3));
  }
  bool accepted(std::size_t count, Duration limit = seconds(2)) {
    return bench.run_until(
        [&] { return bench.control.accepted.size() == count && bench.walker.unanswered() == 0; }, limit);
  }
  WalkerBench bench;
};

bool carries(const hal::bus::StepCommand& c, const hal::Footstep& s) {
  return c.foot == static_cast<hal::bus::StepCommand::Foot>(s.foot) && c.dx == s.landing.x &&
         c.dy == s.landing.y && c.dtheta == s.landing.yaw && c.dz == s.dz &&
         std::abs(c.duration - to_seconds(s.duration)) < 1e-9;
}

// --- steps ---

TEST_F(Walking, StepsArriveInOrderAndUnchanged) {
  for (std::uint32_t i = 0; i < 5; ++i) ASSERT_TRUE(bench.send(3, i));
  ASSERT_TRUE(accepted(5));
  for (std::uint32_t i = 0; i < 5; ++i) {
    EXPECT_EQ(bench.control.accepted[i].seq, i);
    EXPECT_EQ(bench.control.accepted[i].session, 3);
    EXPECT_TRUE(carries(bench.control.accepted[i], step_of(i)));
  }
  EXPECT_EQ(bench.walker.status().accepted, 4);
}

TEST_F(Walking, NumbersGoOnBeyond63) {
  for (std::uint32_t i = 0; i < 200; ++i) {
    ASSERT_TRUE(bench.send(3, i)) << i;
    ASSERT_TRUE(accepted(i + 1)) << i;
  }
  EXPECT_EQ(bench.control.accepted.back().seq, 199 % 64);
  EXPECT_TRUE(carries(bench.control.accepted.back(), step_of(199)));
}

TEST_F(Walking, AnUnansweredStepIsRepeatedEvery40Ms) {
  bench.control.accepts = false;
  ASSERT_TRUE(bench.send(3, 0));
  bench.run(milliseconds(405));
  ASSERT_EQ(bench.control.heard.size(), 11u);
  for (std::size_t i = 1; i < bench.control.heard.size(); ++i) {
    EXPECT_EQ(bench.control.heard_at[i] - bench.control.heard_at[i - 1], milliseconds(40));
    auto same = bench.control.heard[i];
    same.crc = bench.control.heard[0].crc;
    same.counter = bench.control.heard[0].counter;
    EXPECT_EQ(same, bench.control.heard[0]);
  }
  bench.control.accepts = true;
  EXPECT_TRUE(accepted(1));
}

TEST_F(Walking, AnAnsweredStepIsNotRepeated) {
  ASSERT_TRUE(bench.send(3, 0));
  ASSERT_TRUE(accepted(1));
  const auto heard = bench.control.heard.size();
  bench.run(seconds(1));
  EXPECT_EQ(bench.control.heard.size(), heard);
}

TEST_F(Walking, SurvivesALostAcceptance) {
  ASSERT_TRUE(bench.send(3, 0));
  ASSERT_TRUE(bench.send(3, 1));
  int lost = 0;
  bench.to_walker = [&](hal::CanFrame& f) {
    return f.id != Status::kId || bench.control.accepted.empty() || ++lost > 4;
  };
  ASSERT_TRUE(accepted(2));
  EXPECT_GT(bench.control.heard.size(), 2u);
  EXPECT_EQ(bench.control.status.reject_reason, Status::RejectReason::kNone);
}

TEST_F(Walking, TakesNoMoreStepsThanItHasSlots) {
  bench.control.deaf = true;
  for (std::uint32_t i = 0; i < CanWalker::kSlots; ++i) ASSERT_TRUE(bench.send(3, i));
  EXPECT_FALSE(bench.send(3, CanWalker::kSlots));
  bench.control.deaf = false;
  ASSERT_TRUE(accepted(CanWalker::kSlots));
  EXPECT_TRUE(bench.send(3, CanWalker::kSlots));
}

TEST_F(Walking, RefusesWrongNumbersSessionsAndStepsThatDoNotFit) {
  EXPECT_FALSE(bench.send(3, 1));
  EXPECT_FALSE(bench.send(0, 0));
  EXPECT_FALSE(bench.send(16, 0));
  EXPECT_FALSE(bench.walker.send(3, {0, {.landing = {0.6, 0.19, 0}}}));
  EXPECT_TRUE(bench.send(3, 0));
  EXPECT_FALSE(bench.send(3, 0));
  EXPECT_FALSE(bench.send(4, 1));
  EXPECT_TRUE(accepted(1));
}

TEST_F(Walking, ARejectionEndsTheSession) {
  bench.control.rejects = 1;
  for (std::uint32_t i = 0; i < 4; ++i) ASSERT_TRUE(bench.send(3, i));
  ASSERT_TRUE(bench.run_until([&] { return bench.walker.unanswered() == 0; }, seconds(1)));
  EXPECT_EQ(bench.control.accepted.size(), 1u);
  EXPECT_EQ(bench.walker.status().reject_reason, StepReject::kReach);
  EXPECT_EQ(bench.walker.status().rejected, 1);
  EXPECT_FALSE(bench.send(3, 4));
  const auto heard = bench.control.heard.size();
  bench.run(seconds(0.5));
  EXPECT_EQ(bench.control.heard.size(), heard);
  // The next session is free of it.
  bench.control.rejects.reset();
  ASSERT_TRUE(bench.begin(4));
  ASSERT_TRUE(bench.send(4, 0));
  EXPECT_TRUE(accepted(1));
}

TEST_F(Walking, WaitsWhileTheQueueIsFull) {
  bench.control.queue_free = 0;
  bench.run(milliseconds(50));
  ASSERT_TRUE(bench.send(3, 0));
  bench.run(milliseconds(200));
  EXPECT_TRUE(bench.control.heard.empty());
  bench.control.queue_free = 2;
  EXPECT_TRUE(accepted(1));
}

TEST_F(Walking, ARejectionForAFullQueueIsNotTheEnd) {
  bench.control.rejects = 0;
  bench.control.reason = Status::RejectReason::kFull;
  ASSERT_TRUE(bench.send(3, 0));
  bench.run(milliseconds(200));
  EXPECT_EQ(bench.walker.status().reject_reason, StepReject::kFull);
  bench.control.rejects.reset();
  EXPECT_TRUE(accepted(1));
}

TEST_F(Walking, StepsWaitForTheirSessionToBeTakenUp) {
  ASSERT_TRUE(bench.send(3, 0));
  ASSERT_TRUE(accepted(1));
  bench.control.status.state = Status::State::kStopping;  // does not begin anything new
  bench.walker.control(WalkRequest::kWalk, 4, {});
  ASSERT_TRUE(bench.send(4, 0));
  const auto heard = bench.control.heard.size();
  bench.run(milliseconds(300));
  EXPECT_EQ(bench.control.heard.size(), heard);
  bench.control.status.state = Status::State::kStanding;
  EXPECT_TRUE(accepted(1));
  EXPECT_EQ(bench.control.accepted[0].session, 4);
}

TEST_F(Walking, AnOldRejectionDoesNotTouchTheNextSession) {
  bench.control.rejects = 0;
  ASSERT_TRUE(bench.send(3, 0));
  ASSERT_TRUE(bench.run_until([&] { return bench.walker.unanswered() == 0; }, seconds(1)));
  bench.control.rejects.reset();
  bench.walker.control(WalkRequest::kWalk, 4, {});
  ASSERT_TRUE(bench.send(4, 0));  // same number, while the old rejection still shows
  EXPECT_TRUE(accepted(1));
}

TEST_F(Walking, AControlComputerThatStartsAnewEndsTheSession) {
  ASSERT_TRUE(bench.send(3, 0));
  ASSERT_TRUE(accepted(1));
  bench.walker.control(WalkRequest::kNone, 3, {});
  bench.run(milliseconds(50));
  bench.control.reboot();
  bench.control.accepts = false;
  bench.run(milliseconds(50));
  EXPECT_FALSE(bench.send(3, 1));
}

// --- the walk ---

// --- orders ---

hal::NumberedStep part(std::uint32_t index, std::uint8_t place, double x = 2) {
  return {index, step_of(index),
          hal::PartOfOrder{{hal::WalkOrder::Kind::kStraightWithTurn, x, 0, 0.1}, place}};
}

TEST_F(Walking, AnOrderIsRepeatedUntilItsFirstStepIsAcceptedAndThenReleasedStepByStep) {
  for (std::uint8_t i = 0; i < 3; ++i) ASSERT_TRUE(bench.walker.send(3, part(i, i)));
  bench.run(milliseconds(100));
  ASSERT_GE(bench.control.orders.size(), 2U);
  EXPECT_EQ(bench.control.orders.back().x, 2);
  EXPECT_EQ(bench.control.orders.back().theta, 0.1);
  EXPECT_EQ(bench.control.orders.back().seq, 0);
  EXPECT_TRUE(bench.control.heard.empty()) << "no step travels by itself";
  EXPECT_EQ(bench.control.controls.back().last_seq, 63) << "nothing is released before it is accepted";
  bench.control.status.seq_accepted = 0;
  bench.run(milliseconds(50));
  const std::size_t sent = bench.control.orders.size();
  EXPECT_EQ(bench.control.controls.back().last_seq, 2);
  EXPECT_EQ(bench.walker.unanswered(), 0U);
  ASSERT_TRUE(bench.walker.send(3, part(3, 3)));
  bench.run(milliseconds(100));
  EXPECT_EQ(bench.control.controls.back().last_seq, 3);
  EXPECT_EQ(bench.control.orders.size(), sent);
}

TEST_F(Walking, TheReleaseStaysBeforeANewerOrderUntilThatIsAccepted) {
  for (std::uint8_t i = 0; i < 3; ++i) ASSERT_TRUE(bench.walker.send(3, part(i, i)));
  bench.run(milliseconds(50));
  bench.control.status.seq_accepted = 0;
  bench.run(milliseconds(50));
  const std::size_t sent = bench.control.orders.size();
  ASSERT_TRUE(bench.walker.send(3, part(3, 0, -1)));
  ASSERT_TRUE(bench.walker.send(3, part(4, 1, -1)));
  bench.run(milliseconds(100));
  EXPECT_EQ(bench.control.controls.back().last_seq, 2);
  EXPECT_EQ(bench.control.orders.size(), sent) << "steps 1 and 2 are not accepted yet";
  bench.control.status.seq_accepted = 2;
  bench.run(milliseconds(100));
  EXPECT_EQ(bench.control.controls.back().last_seq, 2);
  ASSERT_GT(bench.control.orders.size(), sent);
  EXPECT_EQ(bench.control.orders.back().seq, 3);
  EXPECT_EQ(bench.control.orders.back().x, -1);
  bench.control.status.seq_accepted = 3;
  bench.run(milliseconds(50));
  EXPECT_EQ(bench.control.controls.back().last_seq, 4);
}

TEST_F(Walking, RefusesAStepOfAnOrderThatItWasNotGiven) {
  EXPECT_FALSE(bench.walker.send(3, part(0, 1)));
  ASSERT_TRUE(bench.walker.send(3, part(0, 0)));
  EXPECT_FALSE(bench.walker.send(3, part(1, 2)));
  EXPECT_FALSE(bench.walker.send(3, part(1, 1, 1.5))) << "of another order";
  ASSERT_TRUE(bench.send(3, 1)) << "a step by itself may follow";
  EXPECT_FALSE(bench.walker.send(3, part(2, 1)));
  EXPECT_FALSE(bench.walker.send(3, part(2, 0, 9))) << "which no frame can hold";
}

TEST_F(Walking, ARejectedOrderEndsTheSession) {
  ASSERT_TRUE(bench.walker.send(3, part(0, 0)));
  bench.run(milliseconds(50));
  bench.control.status.seq_rejected = 0;
  bench.control.status.reject_reason = Status::RejectReason::kReach;
  bench.run(milliseconds(50));
  EXPECT_FALSE(bench.walker.send(3, part(1, 1)));
  EXPECT_EQ(bench.walker.unanswered(), 0U);
}

TEST_F(Walking, ControlTravelsEvery40Ms) {
  bench.control.controls_at.clear();
  bench.run(seconds(1));
  ASSERT_EQ(bench.control.controls_at.size(), 25u);
}

TEST_F(Walking, AChangedRequestTravelsAtOnce) {
  bench.run(milliseconds(45));
  bench.walker.control(WalkRequest::kSmoothStop, 3, seconds(0.25));
  bench.cycle();
  EXPECT_EQ(bench.control.controls.back().request, hal::bus::WalkControl::Request::kSmoothStop);
  EXPECT_EQ(bench.control.controls_at.back(), bench.now);
  EXPECT_EQ(bench.control.controls.back().session, 3);
  EXPECT_NEAR(bench.control.controls.back().map_age, 0.25, 1e-9);
}

TEST_F(Walking, TheNewestStepAndAgeAreTold) {
  EXPECT_EQ(bench.control.controls.back().last_seq, 63);
  ASSERT_TRUE(bench.send(3, 0));
  ASSERT_TRUE(bench.send(3, 1));
  bench.walker.control(WalkRequest::kWalk, 3, seconds(1e6));
  bench.run(milliseconds(50));
  EXPECT_EQ(bench.control.controls.back().last_seq, 1);
  EXPECT_EQ(bench.control.controls.back().map_age, 65.535);
}

// --- watching ---

TEST(CanWalkerHealth, IsStartingUntilSomethingIsHeard) {
  WalkerBench bench;
  bench.control.mute_status = bench.control.mute_chest = true;
  bench.run(seconds(1));
  EXPECT_EQ(bench.walker.health(), WalkerHealth::kStarting);
  EXPECT_FALSE(bench.send(1, 0));
}

TEST_F(Walking, IsLostWithoutStatusFor100MsAndHoldsItsSteps) {
  bench.control.mute_status = true;
  bench.run(milliseconds(80));
  EXPECT_EQ(bench.walker.health(), WalkerHealth::kReady);
  ASSERT_TRUE(bench.send(3, 0));
  bench.run(milliseconds(45));
  EXPECT_EQ(bench.walker.health(), WalkerHealth::kLost);
  EXPECT_FALSE(bench.send(3, 1));
  const auto heard = bench.control.heard.size();
  bench.run(milliseconds(400));
  EXPECT_EQ(bench.control.heard.size(), heard);
  bench.control.mute_status = false;
  bench.run(milliseconds(60));
  EXPECT_EQ(bench.walker.health(), WalkerHealth::kReady);
  EXPECT_TRUE(accepted(1));
}

TEST_F(Walking, HasNoChestWithoutEitherHalf) {
  bench.control.mute_rotation = true;
  const Time last = bench.walker.chest().stamp;
  bench.run(milliseconds(80));
  EXPECT_EQ(bench.walker.health(), WalkerHealth::kReady);
  bench.run(milliseconds(50));
  EXPECT_EQ(bench.walker.health(), WalkerHealth::kNoChest);
  EXPECT_LE(bench.walker.chest().stamp, last + milliseconds(20));
  bench.control.mute_rotation = false;
  bench.run(milliseconds(50));
  EXPECT_EQ(bench.walker.health(), WalkerHealth::kReady);
}

TEST_F(Walking, FramesWithABadCrcAreCountedAndNotUsed) {
  bench.control.spoil_status = true;
  const auto before = bench.walker.counts().wrong_crc;
  bench.run(milliseconds(200));
  EXPECT_EQ(bench.walker.counts().wrong_crc - before, 10u);
  EXPECT_EQ(bench.walker.health(), WalkerHealth::kLost);
}

TEST_F(Walking, AStuckCounterIsCountedAndNotUsedHoweverLongItLasts) {
  bench.control.stick_counter = true;
  bench.run(milliseconds(130));
  const auto before = bench.walker.counts().repeated;
  for (int i = 0; i < 400; ++i) {
    bench.cycle();
    ASSERT_EQ(bench.walker.health(), WalkerHealth::kLost);
  }
  EXPECT_EQ(bench.walker.counts().repeated - before, 100u);
}

TEST_F(Walking, UndeclaredValuesAreCountedAndNotUsed) {
  hal::CanFrame frame = *Status{}.pack();
  frame.data[1] = 0xF0;  // a state that has no name
  hal::bus::Protector protector(Status::kDataId);
  CanWalker walker(bench.bus);
  protector.protect(frame);
  frame.stamp = bench.now;
  walker.receive(frame);
  walker.tick(bench.now);
  EXPECT_EQ(walker.counts().undeclared, 1u);
  EXPECT_EQ(walker.health(), WalkerHealth::kStarting);
}

TEST_F(Walking, TheClockIsSynchronisedWhileItIsHeard) {
  bench.run(seconds(1.1));
  EXPECT_TRUE(bench.walker.clock_is_synchronised());
  bench.control.mute_time = true;
  bench.run(seconds(5.1));
  EXPECT_FALSE(bench.walker.clock_is_synchronised());
}

TEST_F(Walking, KnowsHowFarItsClockIsFromOursUntilThatStaysAway) {
  bench.run(seconds(1.1));
  EXPECT_FALSE(bench.walker.clock()) << "one frame may have travelled for long";
  bench.run(seconds(2));
  const auto clock = bench.walker.clock();
  ASSERT_TRUE(clock);
  EXPECT_LE(std::chrono::abs(clock->offset - bench.control.clock_apart), clock->uncertainty);
  EXPECT_LT(clock->uncertainty, milliseconds(7));
  bench.control.mute_time = true;
  bench.run(seconds(5.1));
  EXPECT_FALSE(bench.walker.clock());
}

// --- the chest ---

TEST_F(Walking, TheChestPoseIsTheOneSentAtItsOwnTime) {
  bench.control.chest_x = 1.234;
  bench.control.yaw = 0.5;
  bench.control.age = 0.013;
  bench.run(milliseconds(40));
  const hal::ChestSample chest = bench.walker.chest();
  const Time received = bench.now - (bench.now - chest.stamp - milliseconds(13));
  EXPECT_EQ(chest.stamp, received - milliseconds(13));
  EXPECT_LE(bench.now - received, milliseconds(20));
  const Eigen::Isometry3d expected =
      Eigen::Translation3d(1.234, -1, 0.9) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(-0.04, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX());
  EXPECT_TRUE(chest.odom_from_chest.isApprox(expected, 1e-12));
}

TEST(ChestPose, IsNotPairedAcrossTheTurnOfTheSampleNumber) {
  testing::ScriptedBus bus;
  CanWalker walker(bus);
  hal::bus::Protector xy(hal::bus::ChestXY::kDataId), rotation(hal::bus::ChestZRot::kDataId);
  const auto hear = [&](std::optional<hal::CanFrame> frame, hal::bus::Protector& protector, Time stamp) {
    protector.protect(frame.value());
    frame->stamp = stamp;
    walker.receive(*frame);
  };
  hear(hal::bus::ChestXY{.sample = 5}.pack(), xy, at_seconds(1));
  hear(hal::bus::ChestZRot{.sample = 5}.pack(), rotation, at_seconds(1.32));
  EXPECT_EQ(walker.chest().stamp, Time{});
  hear(hal::bus::ChestXY{.sample = 5}.pack(), xy, at_seconds(1.321));
  EXPECT_EQ(walker.chest().stamp, at_seconds(1.321));
}

RC_GTEST_PROP(ChestPose, NeverMixesHalvesOfDifferentPoses, ()) {
  WalkerBench bench;
  const unsigned loss = *rc::gen::inRange(0u, 60u);
  testing::Noise noise(*rc::gen::inRange(1u, 1u << 30));
  bench.to_walker = [&](hal::CanFrame&) { return noise.percent() >= loss; };
  Time last{};
  for (int i = 0; i < 400; ++i) {
    // x and yaw of one pose belong together.
    bench.control.chest_x = 0.01 * i;
    bench.control.yaw = 0.0001 * i;
    bench.cycle();
    const hal::ChestSample chest = bench.walker.chest();
    RC_ASSERT(chest.stamp >= last);
    last = chest.stamp;
    if (chest.stamp == Time{}) continue;
    const Eigen::Matrix3d r = chest.odom_from_chest.linear();
    const double yaw = std::atan2(r(1, 0), r(0, 0));
    RC_ASSERT(std::abs(chest.odom_from_chest.translation().x() - 100 * yaw) < 0.005);
    // And they belong to that time: the pose of i was sent in cycle i.
    const double cycle = to_seconds(chest.stamp - at_seconds(50)) / 0.005 - 1 + 0.004 / 0.005;
    RC_ASSERT(std::abs(chest.odom_from_chest.translation().x() - 0.01 * std::round(cycle)) < 0.005);
  }
}

// --- whatever happens on the bus ---

RC_GTEST_PROP(Steps, AreAcceptedOnceEachInOrderOverALossyBus, ()) {
  WalkerBench bench;
  bench.run(milliseconds(100));
  RC_ASSERT(bench.begin(1));
  const unsigned loss = *rc::gen::inRange(0u, 40u), damage = *rc::gen::inRange(0u, 20u);
  testing::Noise noise(*rc::gen::inRange(1u, 1u << 30));
  bench.to_walker = bench.to_control = [&](hal::CanFrame& f) {
    if (noise.percent() < damage) {
      const std::size_t byte = noise.below(8);
      f.data[byte] = static_cast<std::uint8_t>(f.data[byte] ^ (1u << noise.below(8)));
    }
    return noise.percent() >= loss;
  };
  std::uint32_t next = 0;
  const std::uint32_t total = *rc::gen::inRange(1u, 100u);
  for (int i = 0; i < 20000 && bench.control.accepted.size() < total; ++i) {
    if (next < total && bench.send(1, next)) ++next;
    bench.cycle();
  }
  RC_ASSERT(bench.control.accepted.size() == total);
  for (std::uint32_t i = 0; i < total; ++i) {
    RC_ASSERT(bench.control.accepted[i].seq == i % 64);
    RC_ASSERT(carries(bench.control.accepted[i], step_of(i)));
  }
}

}  // namespace
}  // namespace headway::drivers
