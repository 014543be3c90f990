// The mission's decisions, frame by frame, on reports of the bus that are made by hand.
#include "runtime/mission.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/runtime/mission_bench.h"

namespace headway::runtime {
namespace {

using testing::HasSubstr;

/// Looks around for what is unseen, with a camera in the head 40 deg wide.
MissionConfig exploring() {
  MissionConfig config = hand_made();
  const auto row = [](double x, double y, double z, double w) {
    return vision::half_space(Eigen::Vector4d(x, y, z, w));
  };
  config.field = *vision::minimal_polytope({row(1, 0, 0.36, 0), row(-1, 0, 0.36, 0), row(0, 1, 0.36, 0),
                                            row(0, -1, 0.36, 0), row(0, 0, 1, -0.5), row(0, 0, -1, 4)});
  config.next_view.emplace();
  return config;
}

TEST(Mission, WaitsForTheDrivesAndTheControlComputer) {
  Bench bench;
  bench.mission.set_goal(kAhead);
  bench.bus.walker = hal::WalkerHealth::kStarting;
  bench.frames(5);
  EXPECT_EQ(bench.mission.state(), MissionState::kStarting);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
  bench.bus.walker = hal::WalkerHealth::kReady;
  bench.frames(1);
  EXPECT_EQ(bench.mission.state(), MissionState::kLookAround);
}

TEST(Mission, LooksAroundAndThenWaitsForAGoal) {
  Bench bench;
  bench.frames(20);
  EXPECT_EQ(bench.mission.state(), MissionState::kWaitGoal);
  EXPECT_EQ(bench.mission.views_taken(), 3U);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
  bench.until_walking(kAhead);
  EXPECT_EQ(bench.mission.state(), MissionState::kWalk);
  EXPECT_EQ(bench.order.walk, Walk::kPlan);
  EXPECT_GT(bench.order.plan.count, 10);
  EXPECT_TRUE(bench.order.plan.complete);
  EXPECT_EQ(bench.order.plan.newest_frame, bench.now);
}

TEST(Mission, LooksAroundUntilNothingIsLeftToGain) {
  Bench bench(exploring());
  bench.blind = "what the head sees does not come out";  // so every direction stays worth a look, once
  bench.frames(2);
  EXPECT_EQ(bench.mission.state(), MissionState::kLookAround);
  bench.frames(100);
  EXPECT_EQ(bench.mission.state(), MissionState::kWaitGoal);
  const std::size_t at_nothing = bench.mission.views_taken();
  EXPECT_GT(at_nothing, 6U);
  EXPECT_LT(at_nothing, 30U);
  Bench seeing(exploring());
  seeing.frames(102);
  EXPECT_EQ(seeing.mission.state(), MissionState::kWaitGoal);
  EXPECT_LT(seeing.mission.views_taken(), at_nothing)
      << "what has been seen from above need not be looked at";
}

TEST(Mission, LooksFirstWhereMostIsToBeGained) {
  Bench bench(exploring());
  bench.frames(2);
  nav::NextView next({bench.mission_config.field, bench.mission_config.neck, bench.mission_config.head},
                     bench.mapper.voxels().resolution(), *bench.mission_config.next_view);
  bench.frames(1);
  const auto looks = next.turns(bench.mapper.voxels(), bench.chest(), {}, {});
  ASSERT_FALSE(looks.empty());
  EXPECT_EQ(bench.order.look.pan, looks[0].head.pan);
  EXPECT_EQ(bench.order.look.tilt, looks[0].head.tilt);
}

TEST(Mission, DoesNotLookAroundForAnotherGoalWhereAllIsKnown) {
  MissionConfig config = exploring();
  config.next_view->least_gain = 100;
  Bench bench(config);
  bench.until_walking(kAhead);
  EXPECT_EQ(bench.mission.views_taken(), 0U);
  bench.walk_all();
  ASSERT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
}

TEST(Mission, LooksAtAllViewpointsAgainWhenItIsHeldUp) {
  MissionConfig config = exploring();
  config.next_view->least_gain = 100;  // nothing unseen is worth a look
  Bench bench(config);
  bench.boxes = {box(1.5, 1.7, -3, 3, 1.2)};
  bench.until_walking(kAhead);
  bench.until_over();
  EXPECT_THAT(bench.mission.reason(), HasSubstr("no way to the goal"));
  EXPECT_EQ(bench.mission.views_taken(),
            config.viewpoints.size() * static_cast<std::size_t>(bench.mission.counters().look_arounds - 1));
  EXPECT_GE(bench.mission.counters().look_arounds, 2);
}

TEST(Mission, ArrivesWhenAllIsWalked) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.walk_all();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
  EXPECT_NEAR(bench.bus.committed.stance.base().x, 3, 0.07);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
}

TEST(Mission, LooksWhereItIsToldOnlyWhereItRests) {
  Bench bench;
  bench.frames(20);
  ASSERT_EQ(bench.mission.state(), MissionState::kWaitGoal);
  bench.mission.look({.around = false, .head = {0.4, 0.3}});
  bench.frames(1);
  EXPECT_EQ(bench.order.look.pan, 0.4);
  EXPECT_EQ(bench.order.look.tilt, 0.3);
  bench.mission.look({.around = false, .head = {9, 0.3}});
  bench.frames(1);
  EXPECT_EQ(bench.order.look.pan, bench.mission_config.head.upper.pan) << "no farther than the neck turns";
  bench.until_walking(kAhead);
  ASSERT_EQ(bench.mission.state(), MissionState::kWalk);
  bench.mission.look({.around = true, .head = {}});
  bench.frames(1);
  EXPECT_EQ(bench.mission.state(), MissionState::kWalk);
}

TEST(Mission, ALookIsNotFollowedByAWalkToAGoalThatIsOver) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.walk_all();
  ASSERT_EQ(bench.mission.state(), MissionState::kArrived);
  bench.bus.committed.stance = hal::Stance::parallel({1, 0, 0}, bench.mission_config.gait.feet_apart);
  bench.mission.look({.around = true, .head = {}});
  bench.frames(1);
  EXPECT_EQ(bench.mission.state(), MissionState::kLookAround);
  bench.frames(40);
  EXPECT_EQ(bench.mission.state(), MissionState::kWaitGoal);
  EXPECT_EQ(bench.order.walk, Walk::kStop);
}

TEST(Mission, WalksInOrdersAndGivesNewOnesWhereAWalkEndedAmidOne) {
  MissionConfig config = hand_made();
  config.execution = nav::Execution::kOrders;
  Bench bench(config);
  bench.until_walking(kAhead);
  ASSERT_EQ(bench.order.walk, Walk::kPlan);
  ASSERT_TRUE(bench.order.plan.in_orders);
  ASSERT_GT(bench.order.plan.count, 5);
  EXPECT_EQ(bench.order.plan.orders[0].place, 0);
  EXPECT_EQ(bench.order.plan.orders[4].place, 4);
  bench.commit(2);
  bench.frames(1);
  EXPECT_EQ(bench.order.plan.orders[0].place, 2) << "the order goes on";
  // A step of another order, which leads where this one would.
  bench.commit(1);
  bench.bus.committed.part->order.x += 0.002;
  bench.frames(1);
  EXPECT_EQ(bench.order.plan.orders[0].place, 0) << "a new order from there";
  bench.commit(2);
  bench.end_session(nav::StackStop::kMissed, 5);
  bench.frames(1);
  ASSERT_EQ(bench.order.walk, Walk::kPlan);
  EXPECT_EQ(bench.order.plan.orders[0].place, 0);
  bench.walk_all();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
}

TEST(Mission, GoesAsNearAsItGetsAndSaysWhy) {
  Bench bench;
  bench.boxes = {box(1.9, 2.1, -3, 3, 1.2)};
  nav::Goal behind = kAhead;
  behind.near = true;
  bench.until_walking(behind);
  bench.walk_all();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
  EXPECT_THAT(bench.mission.reason(), HasSubstr("as near as it gets"));
  EXPECT_NEAR(bench.bus.committed.stance.base().x, 3 - bench.mission.short_of_goal(), 0.07);
}

TEST(Mission, WalksNothingThatWouldTipTheRobot) {
  MissionConfig config = hand_made();
  config.gait.zmp_margin = 0.068;  // a millimetre around the middle of the sole: no step keeps that
  Bench bench(config);
  bench.until_walking(kAhead);
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_THAT(bench.mission.reason(), HasSubstr("would tip the robot: in step "));
  EXPECT_THAT(bench.mission.reason(), HasSubstr("expected 68 mm or more"));
  EXPECT_EQ(bench.order.walk, Walk::kStop);
}

TEST(Mission, GoesOnWithTheRestWhenAWalkEndsEarly) {
  Bench bench;
  bench.until_walking(kAhead);
  const nav::StepPlan plan = bench.order.plan;
  const int plans = bench.mission.counters().replans;
  bench.commit(4);
  bench.frames(1);
  bench.end_session(nav::StackStop::kStale, 4);
  bench.frames(1);
  EXPECT_EQ(bench.mission.state(), MissionState::kWalk);
  EXPECT_EQ(bench.order.walk, Walk::kPlan);
  EXPECT_EQ(bench.order.plan.session, 2);
  EXPECT_EQ(bench.order.plan.first_index, 0U);
  EXPECT_EQ(bench.order.plan.count, plan.count - 4);
  EXPECT_EQ(bench.order.plan.steps[0].foot, plan.steps[4].foot);
  EXPECT_EQ(bench.order.plan.steps[0].landing.x, plan.steps[4].landing.x);
  EXPECT_EQ(bench.mission.counters().replans, plans) << "that is no change of mind";
}

TEST(Mission, PlansAnewWhenAWalkEndsWhereThePlanDoesNotKnow) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.commit(4);
  bench.frames(1);
  bench.end_session(nav::StackStop::kLost, 4);
  bench.bus.committed.stance = hal::Stance::parallel({0.5, 0.3, 0.2}, 0.19);
  bench.frames(1);
  ASSERT_EQ(bench.order.walk, Walk::kPlan);
  hal::Stance end = bench.bus.committed.stance;
  for (int i = 0; i < bench.order.plan.count; ++i)
    end = end.after(bench.order.plan.steps[static_cast<std::size_t>(i)]);
  EXPECT_NEAR(end.base().x, 3, 0.05);
  EXPECT_NEAR(end.base().y, 0, 0.05);
}

TEST(Mission, GoesOnFromTheEndOfAWalkThatLedBesideTheGoal) {
  Bench bench;
  bench.boxes = {box(3.31, 3.8, -0.5, 0.5, 1.2)};
  bench.until_walking(kAhead);
  ASSERT_EQ(bench.order.walk, Walk::kPlan);
  const double end = bench.mission.walk()->path.end.x();
  ASSERT_LT(end, 3 - bench.mission_config.goal_tolerance) << "near enough for a plan, not to arrive";
  while (bench.order.plan.count > 2) {
    bench.commit(1);
    bench.frames(1);
  }
  bench.boxes.clear();  // it goes away when hardly a step is left
  bench.frames(30);
  ASSERT_NEAR(bench.mission.walk()->path.end.x(), end, 1e-9) << "not worth another plan";
  bench.walk_all();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
  EXPECT_NEAR(bench.bus.committed.stance.base().x, 3, 0.02);
}

TEST(Mission, GivesUpWhenTheControlComputerReportsAFault) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.bus.walk.state = hal::WalkState::kFault;
  bench.frames(1);
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_THAT(bench.mission.reason(), HasSubstr("control computer reports a fault"));
}

TEST(Mission, GivesUpWhenTheControlComputerRefusesEveryWalk) {
  const std::pair<nav::StackStop, const char*> all[] = {{nav::StackStop::kRejected, "beyond what it allows"},
                                                        {nav::StackStop::kNoStart, "does not begin to walk"},
                                                        {nav::StackStop::kLost, "reports stay away"}};
  for (const auto& [stop, reason] : all) {
    Bench bench;
    bench.until_walking(kAhead);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(bench.mission.state(), MissionState::kWalk) << "after " << i << " refusals";
      bench.end_session(stop, 0, hal::StepReject::kReach);
      bench.frames(2);
    }
    EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
    EXPECT_THAT(bench.mission.reason(), HasSubstr(reason));
  }
}

TEST(Mission, ForgetsRefusalsWhenStepsAreWalked) {
  Bench bench;
  bench.until_walking(kAhead);
  for (int i = 0; i < 9; ++i) {
    bench.end_session(nav::StackStop::kRejected, i % 2 ? 0 : 2, hal::StepReject::kLate);
    bench.frames(2);
  }
  EXPECT_EQ(bench.mission.state(), MissionState::kWalk);
}

TEST(Mission, GivesUpWhenNothingHasBeenSeenForLong) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.blind = "no light";
  bench.frames(99);
  EXPECT_EQ(bench.mission.state(), MissionState::kWalk);
  EXPECT_EQ(bench.order.plan.newest_frame, bench.last_look) << "and says how old its map is";
  bench.frames(3);
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_EQ(bench.mission.reason(), "nothing has been seen for 10 s: no light");
}

TEST(Mission, GivesUpWhenTheHeadHasNotBeenReadyForLong) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.bus.head.health = hal::HeadHealth::kFault;
  bench.frames(90);
  EXPECT_FALSE(bench.mission.over()) << "drives come back by themselves";
  bench.until_over();
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_NE(bench.mission.reason().find("the head has not been ready"), std::string::npos);
}

TEST(Mission, LooksForItsPlaceFirstAndGivesUpWhereTheViewsFitNowhere) {
  Bench bench;
  bench.placed = false;
  bench.mission.set_goal(kAhead);
  bench.frames(2);
  EXPECT_EQ(bench.mission.state(), MissionState::kLookAround);
  bench.until_over();
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_NE(bench.mission.reason().find("set the robot up"), std::string::npos);
  EXPECT_EQ(bench.mission.counters().plans, 0);
  // It may be tried again, and this time a view fits.
  bench.mission.set_goal(kAhead);
  bench.frames(2);
  EXPECT_EQ(bench.mission.state(), MissionState::kLookAround);
  bench.placed = true;
  bench.until_walking(kAhead);
  EXPECT_EQ(bench.order.walk, Walk::kPlan);
}

TEST(Mission, DoesNotCountALookThatTheEyesCouldNotUse) {
  Bench bench;
  bench.mission.set_goal(kAhead);
  bench.frames(1);
  bench.blind = "the left camera is covered";
  bench.faulty = true;
  bench.frames(60);
  EXPECT_EQ(bench.mission.state(), MissionState::kLookAround);
  EXPECT_EQ(bench.mission.views_taken(), 0U);
  bench.blind.clear();
  bench.faulty = false;
  bench.frames(20);
  EXPECT_GT(bench.mission.views_taken(), 0U);
}

TEST(Mission, GivesUpWhenThereIsNoWay) {
  Bench bench;
  bench.boxes = {box(1.5, 1.7, -3, 3, 1.2)};
  bench.until_walking(kAhead);
  bench.until_over();
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_THAT(bench.mission.reason(), HasSubstr("no way to the goal"));
  EXPECT_GE(bench.mission.counters().look_arounds, 2) << "it looks again before it says so";
}

/// A wall has come across the way, and the robot is where it does not see it: it sees 2.2 m ahead, and 3.7 m
/// when it looks around.
struct PassingWall : Bench {
  const Boxes wall = {box(4.2, 4.4, -3, 3, 0.6)};

  PassingWall() {
    frames(20);
    boxes = wall;
    frames(5);
    eye = {-1.5, 0};
    frames(1);
  }
  void go() {
    mission.set_goal({{4.8, 0}, std::nullopt});
    for (int i = 0; i < 900 && !mission.over(); ++i) {
      const int left = order.walk == Walk::kPlan ? order.plan.count : 0;
      if (left > 0) commit(1);
      if (left <= 1 && !bus.committed.at_rest) end_session(nav::StackStop::kNone, 1);
      eye.x() = bus.committed.stance.base().x - (mission.state() == MissionState::kLookAround ? 0 : 1.5);
      frames(1);
    }
  }
};

TEST(Mission, GoesAndSeesWhetherWhatCameAcrossEveryWayHasGone) {
  PassingWall bench;
  bench.boxes = {};
  bench.go();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
}

TEST(Mission, GivesUpWhereWhatCameAcrossEveryWayStillStands) {
  PassingWall bench;
  bench.go();
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_THAT(bench.mission.reason(), HasSubstr("no way to the goal"));
  const double reached = bench.bus.committed.stance.base().x;
  EXPECT_GT(reached, 1.5) << "near enough to see it";
  EXPECT_LT(reached, 3.9);
}

TEST(Mission, DoesNotGoToSeeWhetherWhatAlwaysStoodThereHasGone) {
  Bench bench;
  bench.boxes = {box(4.2, 4.4, -3, 3, 0.6)};
  bench.frames(20);
  bench.eye = {-1.5, 0};
  bench.mission.set_goal({{4.8, 0}, std::nullopt});
  for (int i = 0; i < 300 && !bench.mission.over(); ++i) {
    bench.frames(1);
    ASSERT_NE(bench.order.walk, Walk::kPlan);
  }
  EXPECT_THAT(bench.mission.reason(), HasSubstr("no way to the goal"));
}

TEST(Mission, GivesUpAtFloorThatCannotBeSeen) {
  Bench bench;
  bench.eye = {-2.2, 0};  // sees no farther than x = 1.5
  bench.until_walking({{4.5, 0}, std::nullopt});
  bench.walk_all();
  bench.until_over();
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_THAT(bench.mission.reason(), HasSubstr("the floor cannot be seen at"));
  EXPECT_GE(bench.mission.counters().pauses, 4) << "it looked where that floor should be";
}

TEST(Mission, GivesUpBeforeAnObstacleWhenItMayNotReplan) {
  MissionConfig config = hand_made();
  config.replan = false;
  Bench bench(config);
  bench.until_walking(kAhead);
  bench.boxes = {box(0.35, 0.6, -0.5, 0.5, 1.0)};
  bench.until_over();
  EXPECT_EQ(bench.mission.state(), MissionState::kStopped);
  EXPECT_THAT(bench.mission.reason(), HasSubstr("an obstacle stands on the way"));
}

TEST(Mission, GoesAroundAnObstacleThatTurnsUp) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.commit(3);
  bench.boxes = {box(1.5, 1.9, -0.4, 0.3, 1.0)};
  bench.frames(5);
  EXPECT_GE(bench.mission.counters().replans, 1);
  bench.walk_all();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
}

TEST(Mission, SetsOutAgainForAnotherGoalAfterItHasArrived) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.walk_all();
  ASSERT_EQ(bench.mission.state(), MissionState::kArrived);
  const int before = bench.mission.counters().look_arounds;
  bench.mission.set_goal({{3, 1}, std::nullopt});
  EXPECT_EQ(bench.mission.state(), MissionState::kLookAround);
  bench.frames(10);
  EXPECT_EQ(bench.mission.counters().look_arounds, before + 1);
  bench.walk_all();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
  EXPECT_NEAR(bench.bus.committed.stance.base().y, 1, 0.07);
}

TEST(Mission, SetsOutAgainForAnotherGoalAfterItHasGivenUp) {
  Bench bench;
  bench.boxes = {box(1.5, 1.7, -3, 3, 1.2)};
  bench.until_walking(kAhead);
  bench.until_over();
  ASSERT_EQ(bench.mission.state(), MissionState::kStopped);
  bench.mission.set_goal({{0.5, 1}, std::nullopt});
  EXPECT_TRUE(bench.mission.reason().empty());
  bench.frames(10);
  bench.walk_all();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
}

TEST(Mission, TurnsToAnotherGoalWhileItWalks) {
  Bench bench;
  bench.until_walking(kAhead);
  bench.commit(3);
  bench.frames(1);
  bench.mission.set_goal({{1, 1.5}, std::nullopt});
  bench.frames(1);
  EXPECT_EQ(bench.order.plan.first_index, 3U) << "what is committed is walked";
  bench.walk_all();
  EXPECT_EQ(bench.mission.state(), MissionState::kArrived) << bench.mission.reason();
  EXPECT_NEAR(bench.bus.committed.stance.base().y, 1.5, 0.07);
}

}  // namespace
}  // namespace headway::runtime
