// What the loops exchange comes back from a recording to the last bit.
#include "runtime/recorded_values.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "runtime/recording/cdr.h"

namespace headway::runtime {
namespace {

/// A report with something else in every field.
BusReport drawn_report(std::uint64_t seed) {
  std::mt19937_64 dice(seed);
  const auto number = [&] { return std::uniform_real_distribution<double>(-3, 3)(dice); };
  const auto time = [&] { return Time(Duration(static_cast<Duration::rep>(dice() % (1ULL << 62)))); };
  const auto pose = [&] { return Pose2{number(), number(), number()}; };
  const auto stance = [&] { return hal::Stance{pose(), pose()}; };
  const auto part = [&]() -> std::optional<hal::PartOfOrder> {
    if (dice() % 2 == 0) return std::nullopt;
    return hal::PartOfOrder{
        {hal::WalkOrder::Kind{static_cast<std::uint8_t>(dice() % 3)}, number(), number(), number()},
        static_cast<std::uint8_t>(dice())};
  };
  BusReport r;
  r.stamp = time();
  r.head = {hal::HeadHealth{static_cast<std::uint8_t>(dice() % 5)},
            {number(), number()},
            {number(), number()},
            time(),
            {number(), number()},
            dice() % 2 == 0};
  r.walk.state = hal::WalkState{static_cast<std::uint8_t>(dice() % 4)};
  r.walk.session = static_cast<std::uint8_t>(dice());
  r.walk.executing = static_cast<std::uint8_t>(dice());
  r.walk.accepted = static_cast<std::uint8_t>(dice());
  r.walk.rejected = static_cast<std::uint8_t>(dice());
  r.walk.reject_reason = hal::StepReject{static_cast<std::uint8_t>(dice() % 7)};
  r.walk.queue_free = static_cast<int>(dice() % 9);
  r.walk.phase_remaining = Duration(static_cast<Duration::rep>(dice() % 1'000'000'000));
  r.walk.stamp = time();
  r.walker = hal::WalkerHealth{static_cast<std::uint8_t>(dice() % 4)};
  if (dice() % 2 == 0) r.control_clock = hal::ClockOffset{Duration(-5), Duration(7)};
  r.committed.session = static_cast<std::uint8_t>(dice());
  r.committed.next_index = static_cast<std::uint32_t>(dice());
  r.committed.stance = stance();
  if (dice() % 2 == 0) r.committed.last_foot = hal::Foot{static_cast<std::uint8_t>(dice() % 2)};
  r.committed.part = part();
  r.committed.stopping = dice() % 2 == 0;
  r.committed.why = nav::StackStop{static_cast<std::uint8_t>(dice() % 9)};
  r.committed.at_rest = dice() % 2 == 0;
  r.committed.newest_frame = nav::kNever;
  r.committed.taken = static_cast<std::uint32_t>(dice());
  r.committed.late = static_cast<std::uint32_t>(dice());
  r.committed.refused = static_cast<std::uint32_t>(dice());
  for (nav::CommittedStep& step : r.committed.newest)
    step = {
        {hal::Foot{static_cast<std::uint8_t>(dice() % 2)}, pose(), number(), Duration(800'000'000), number()},
        stance(),
        part()};
  r.last_stop = nav::StackStop{static_cast<std::uint8_t>(dice() % 9)};
  r.last_reject = hal::StepReject{static_cast<std::uint8_t>(dice() % 7)};
  r.last_steps = static_cast<std::uint32_t>(dice());
  return r;
}

RC_GTEST_PROP(RecordedValues, AReportComesBackToTheLastBit, (std::uint64_t seed)) {
  const recorded::BusReport first = to_recorded(drawn_report(seed));
  const auto bytes = recording::to_cdr(first);
  const BusReport back = from_recorded(recording::from_cdr<recorded::BusReport>(bytes));
  RC_ASSERT(recording::to_cdr(to_recorded(back)) == bytes);
}

/// A replay gives the frame loop only what a recording holds: a field more here is a field more there, in
/// recorded_messages.h and recorded_values.cpp; then these sizes change.
TEST(RecordedValues, KnowEveryFieldOfWhatCrossesTheLinks) {
  EXPECT_EQ(sizeof(BusReport), 2240U);
  EXPECT_EQ(sizeof(MotionOrder), 6224U);
  EXPECT_EQ(sizeof(hal::ChestSample), 144U);
  EXPECT_EQ(sizeof(HeadSample), 24U);
}

TEST(RecordedValues, WhatSafetyRestsUponComesBack) {
  BusReport report;
  report.safety.state = SafetyState::kSafeStop;
  report.safety.event = SafetyEvent::kLost;
  report.safety.source = SafetySource::kDrives;
  report.safety.stops = 7;
  report.safety.sources[2].level = SourceLevel::kLost;
  const SafetyReport back = from_recorded(to_recorded(report)).safety;
  EXPECT_EQ(back.state, report.safety.state);
  EXPECT_EQ(back.stops, 7U);
  EXPECT_EQ(describe(back), describe(report.safety));
  MotionOrder order;
  order.seen = Time(Duration(9));
  order.goal = true;
  order.goal_after = 7;
  const recorded::MotionOrder kept = to_recorded(order);
  EXPECT_EQ(kept.seen_ns, 9);
  EXPECT_TRUE(kept.goal);
  EXPECT_EQ(kept.goal_after, 7U);
  const GoalOrder goal{{{1, 2}, 0.5}, 3};
  EXPECT_EQ(from_recorded(to_recorded(goal)).after, 3U);
  EXPECT_EQ(from_recorded(to_recorded(goal)).goal.yaw, 0.5);
  const LookOrder look = from_recorded(to_recorded(LookOrder{true, {0.25, -0.5}}));
  EXPECT_TRUE(look.around);
  EXPECT_EQ(look.head.pan, 0.25);
  EXPECT_EQ(look.head.tilt, -0.5);
}

RC_GTEST_PROP(RecordedValues, SamplesComeBackToTheLastBit, (double a, double b, double c)) {
  hal::ChestSample chest{Time(Duration(5)), Pose2{a, b, std::fmod(c, 3.0)}.lifted(a)};
  const hal::ChestSample back = from_recorded(to_recorded(chest));
  RC_ASSERT(back.stamp == chest.stamp);
  RC_ASSERT(back.odom_from_chest.matrix() == chest.odom_from_chest.matrix() ||
            !chest.odom_from_chest.matrix().allFinite());
  const HeadSample head = from_recorded(to_recorded(HeadSample{Time(Duration(9)), {a, b}}));
  RC_ASSERT(head.stamp == Time(Duration(9)));
  RC_ASSERT(head.angles.pan == a && head.angles.tilt == b);
}

TEST(RecordedValues, AnOrderHoldsItsStepsAndNothingBehindThem) {
  MotionOrder order;
  order.walk = MotionOrder::Walk::kPlan;
  order.plan.count = 2;
  order.plan.steps[0].landing = {0.1, 0.2, 0.3};
  const auto before = recording::to_cdr(to_recorded(order));
  order.plan.steps[2].landing = {9, 9, 9};  // left over from a plan before
  EXPECT_EQ(recording::to_cdr(to_recorded(order)), before);
  order.plan.steps[1].dz = 1e-300;
  EXPECT_NE(recording::to_cdr(to_recorded(order)), before);
}

TEST(RecordedValues, AGoalComesBack) {
  nav::Goal goal{{1.5, -2}, 0.25, 0.1, true};
  nav::Goal back = from_recorded(to_recorded(goal));
  EXPECT_EQ(back.position, goal.position);
  EXPECT_EQ(back.yaw, goal.yaw);
  EXPECT_EQ(back.tolerance, goal.tolerance);
  EXPECT_EQ(back.near, goal.near);
  goal.yaw.reset();
  EXPECT_FALSE(from_recorded(to_recorded(goal)).yaw);
}

}  // namespace
}  // namespace headway::runtime
