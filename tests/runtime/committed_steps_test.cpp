// What the mission makes of the steps that can no longer be taken back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/runtime/mission_bench.h"

namespace headway::runtime {
namespace {

TEST(Mission, StopsForAnObstacleOnStepsThatAreCommitted) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.commit(3);
  bench.frames(1);
  ASSERT_EQ(bench.order.walk, Walk::kPlan);
  EXPECT_EQ(bench.mission.counters().threats, 0);
  const double there = bench.bus.committed.stance.base().x;
  bench.boxes = {box(there, there + 0.2, -0.1, 0.1, 1.2)};
  bench.frames(6);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
  EXPECT_EQ(bench.mission.counters().threats, 1);
  bench.frames(3);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
  EXPECT_EQ(bench.mission.counters().threats, 1);
}

TEST(Mission, SeesAnObstacleOnAStepThatWasCommittedBeforeItsNewPlanCame) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.commit(3);
  bench.frames(1);
  const hal::Footstep next = bench.order.plan.steps[0];
  const double there = nav::gait_base(bench.bus.committed.stance.after(next), next.foot, {}).x;
  bench.boxes = {box(there + 0.12, there + 0.5, 0.22, 0.6, 1.2)};  // an arm would touch it after that step
  for (int i = 0; i < 10 && bench.mission.counters().replans == 0; ++i) bench.frames(1);
  ASSERT_EQ(bench.order.walk, Walk::kPlan);
  ASSERT_EQ(bench.mission.counters().threats, 0);
  bench.commit(next);
  bench.frames(1);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
  EXPECT_EQ(bench.mission.counters().threats, 1);
}

TEST(Mission, SeesAnObstacleOnCommittedStepsWhenItsPlaceIsCorrectedJustThen) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.commit(3);
  bench.frames(1);
  nav::Committed& committed = bench.bus.committed;
  const double there = committed.stance.base().x + 0.1;
  bench.boxes = {box(there, there + 0.2, 0.45, 0.7, 1.2)};
  bench.frames(6);
  ASSERT_EQ(bench.order.walk, Walk::kPlan) << "nothing stands on them yet";
  bench.commit(1);
  const Pose2 correction{0, 0.25, 0};
  for (hal::Stance* stance : {&committed.stance, &committed.newest[1].stance, &committed.newest[2].stance,
                              &committed.newest[3].stance})
    *stance = {correction * stance->left, correction * stance->right};
  bench.frames(1);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
  EXPECT_EQ(bench.mission.counters().threats, 1);
}

TEST(Mission, StopsWhenItCannotForeseeWhereCommittedStepsLead) {
  Bench odd;
  odd.until_walking(kAhead);
  odd.commit(3);
  odd.frames(1);
  hal::Footstep slow = odd.order.plan.steps[0];
  slow.duration = seconds(5);
  odd.commit(slow);
  odd.frames(2);
  EXPECT_EQ(odd.order.walk, Walk::kStop);
  Bench missed;
  missed.until_walking(kAhead);
  missed.commit(10);
  missed.frames(2);
  EXPECT_EQ(missed.order.walk, Walk::kStop);
  missed.end_session(nav::StackStop::kAsked, 10);
  missed.frames(1);
  EXPECT_EQ(missed.order.walk, Walk::kPlan) << "at rest it is known again";
}

TEST(Mission, EndsAtAnObstacleOnCommittedStepsWhenItMayNotReplan) {
  MissionConfig config = hand_made();
  config.replan = false;
  Bench bench(config);
  bench.until_walking(kAhead);
  bench.commit(3);
  bench.frames(1);
  const double there = bench.bus.committed.stance.base().x;
  bench.boxes = {box(there, there + 0.2, -0.1, 0.1, 1.2)};
  bench.frames(6);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_EQ(bench.mission.reason(), "an obstacle came onto steps that were committed");
  EXPECT_EQ(bench.mission.counters().threats, 1);
}

TEST(Mission, EndsWhenItsWalkLeavesThePlanAndItMayNotReplan) {
  MissionConfig config = hand_made();
  config.replan = false;
  Bench bench(config);
  bench.until_walking(kAhead);
  bench.commit(4);
  bench.frames(1);
  bench.end_session(nav::StackStop::kLost, 4);
  bench.bus.committed.stance = hal::Stance::parallel({0.5, 0.3, 0.2}, 0.19);
  bench.frames(1);
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_THAT(bench.mission.reason(), testing::HasSubstr("left the plan"));
}

/// How far the ZMP stays inside the soles when the steps are walked from rest [m].
double margin_of(const hal::Stance& stance, std::span<const hal::Footstep> steps) {
  const nav::GaitLimits gait;
  nav::WalkForecaster forecaster(nav::walking_config(gait), gait.sole_length, gait.sole_width);
  forecaster.rest_at(stance);
  return forecaster.foresee(steps)->margin;
}

TEST(Mission, GoesOnWithTheRestOfAWalkOnlyWhenThatCanBeWalked) {
  const nav::Goal aside{{1, 1.5}, 1.0};
  Bench free;
  free.until_walking(aside);
  const std::span<const hal::Footstep> steps(free.order.plan.steps.data(),
                                             static_cast<std::size_t>(free.order.plan.count));
  ASSERT_TRUE(free.order.plan.complete);
  const double whole = margin_of(free.bus.committed.stance, steps);
  int judged = 0;
  hal::Stance stance = free.bus.committed.stance;
  for (std::size_t done = 1; done < steps.size() && judged < 3; ++done) {
    stance = stance.after(steps[done - 1]);
    const double rest = margin_of(stance, steps.subspan(done));
    if (done < 3 || rest >= whole) continue;
    ++judged;
    MissionConfig config = hand_made();
    config.gait.zmp_margin = (rest + whole) / 2;
    Bench bench(config);
    bench.until_walking(aside);
    for (std::size_t i = 0; i < done; ++i) {
      bench.commit(1);
      bench.frames(1);
    }
    bench.end_session(nav::StackStop::kStale, static_cast<std::uint32_t>(done));
    bench.frames(1);
    const nav::StepPlan& plan = bench.order.plan;
    if (bench.order.walk != Walk::kPlan) continue;
    EXPECT_GE(margin_of(stance, {plan.steps.data(), static_cast<std::size_t>(plan.count)}),
              config.gait.zmp_margin)
        << "after " << done << " steps";
  }
  EXPECT_EQ(judged, 3);
}

TEST(Mission, GoesOnAtRestWhenCommittedStepsAreTakenBack) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.commit(5);
  bench.frames(1);
  nav::Committed& committed = bench.bus.committed;
  committed.next_index = 3;
  committed.stance = committed.step(2)->stance;
  committed.last_foot = committed.step(2)->step.foot;
  committed.stopping = true;
  bench.frames(1);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
  bench.end_session(nav::StackStop::kEnded, 3);
  bench.frames(1);
  EXPECT_EQ(bench.order.walk, Walk::kPlan);
  EXPECT_EQ(bench.order.plan.session, 2);
}

TEST(Mission, PlansOnFromTheStepsThatAreCommitted) {
  Bench bench;
  bench.until_walking(kAhead);
  const nav::StepPlan plan = bench.order.plan;
  bench.commit(3);
  bench.frames(1);
  EXPECT_EQ(bench.order.plan.first_index, 3U);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(bench.order.plan.steps[i].landing.x, plan.steps[i + 3].landing.x) << i;
}

}  // namespace
}  // namespace headway::runtime
