// The mission's decisions, frame by frame, on reports of the bus that are made by hand.
#include "runtime/mission.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/runtime/flat_room.h"

namespace headway::runtime {
namespace {

using testing::HasSubstr;
using Walk = MotionOrder::Walk;

MissionConfig hand_made() {
  MissionConfig config;
  config.neck.chest_from_pan.translation().z() = 0.4;
  config.neck.tilt_from_camera.linear() = hal::body_from_optical();
  config.viewpoints = {{0, 0.5}, {0.6, 0.5}, {-0.6, 0.5}};
  return config;
}

/// A mission, a map that is looked at from above, and a head that is always where it should be.
struct Bench {
  explicit Bench(const MissionConfig& config = hand_made())
      : mission_config(config), mission(config, mapper.floor().grid) {
    bus.head.health = hal::HeadHealth::kReady;
    bus.walker = hal::WalkerHealth::kReady;
    bus.committed.session = 1;
    bus.committed.stance = hal::Stance::parallel({}, config.gait.feet_apart);
  }

  /// So many frames, a tenth of a second each.
  void frames(int count) {
    for (int i = 0; i < count; ++i) {
      now += seconds(0.1);
      if (blind.empty()) {
        mapper.integrate(look(boxes, from_above(eye, 4.5)), from_above(eye, 4.5), chest(), now);
        mapper.project();
        last_look = now;
      }
      order = mission.update({now, last_look, blind, faulty, order.look, chest(), bus, mapper});
    }
  }
  Eigen::Isometry3d chest() const { return bus.committed.stance.base().lifted(1); }
  /// Up to the first order to walk, or the end.
  void until_walking(const nav::Goal& goal) {
    mission.set_goal(goal);
    for (int i = 0; i < 60 && order.walk != Walk::kPlan && !mission.over(); ++i) frames(1);
  }
  void until_over() {
    for (int i = 0; i < 600 && !mission.over(); ++i) frames(1);
  }
  /// The bus loop commits the next steps of the plan that it was given.
  void commit(int steps) {
    for (int i = 0; i < steps; ++i) {
      const hal::Footstep& step = order.plan.steps[static_cast<std::size_t>(i)];
      bus.committed.stance = bus.committed.stance.after(step);
      bus.committed.last_foot = step.foot;
      if (order.plan.in_orders) bus.committed.part = order.plan.orders[static_cast<std::size_t>(i)];
      ++bus.committed.next_index;
      bus.committed.at_rest = false;
    }
  }
  /// The walk ends where it is, and the bus loop opens the next.
  void end_session(nav::StackStop why, std::uint32_t walked,
                   hal::StepReject reject = hal::StepReject::kNone) {
    bus.last_stop = why;
    bus.last_reject = reject;
    bus.last_steps = walked;
    ++bus.committed.session;
    bus.committed.next_index = 0;
    bus.committed.last_foot.reset();
    bus.committed.part.reset();
    bus.committed.at_rest = true;
  }
  /// Walks to the end of the plan.
  void walk_all() {
    for (int i = 0; i < 100 && !mission.over(); ++i) {
      const int left = order.walk == Walk::kPlan ? order.plan.count : 0;
      commit(std::min(left, 1));
      if (left <= 1 && !bus.committed.at_rest) end_session(nav::StackStop::kNone, 1);
      frames(1);
    }
  }

  Boxes boxes;
  Eigen::Vector2d eye{1.7, 0};
  Mapper mapper{small_map(), {}};
  MissionConfig mission_config;
  Mission mission;
  BusReport bus;
  MotionOrder order;
  std::string blind;
  bool faulty = false;
  Time now{}, last_look = nav::kNever;
};

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

const nav::Goal kAhead{{3, 0}, std::nullopt};

TEST(Mission, WaitsForTheDrivesAndTheControlComputer) {
  Bench bench;
  bench.mission.set_goal(kAhead);
  bench.bus.walker = hal::WalkerHealth::kStarting;
  bench.frames(5);
  EXPECT_EQ(bench.mission.state(), MissionState::kStarting);
  EXPECT_EQ(bench.order.walk, Walk::kStay);
  bench.bus.walker = hal::WalkerHealth::kReady;
  bench.frames(1);
  EXPECT_EQ(bench.mission.state(), MissionState::kLookAround);
}

TEST(Mission, LooksAroundAndThenWaitsForAGoal) {
  Bench bench;
  bench.frames(20);
  EXPECT_EQ(bench.mission.state(), MissionState::kWaitGoal);
  EXPECT_EQ(bench.mission.views_taken(), 3U);
  EXPECT_EQ(bench.order.walk, Walk::kStay);
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
  EXPECT_EQ(bench.order.walk, Walk::kStay);
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
  EXPECT_EQ(bench.order.walk, Walk::kStay);
}

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
