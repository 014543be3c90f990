#include "app/sim_session.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/false_obstacles.h"
#include "app/sim_outputs.h"
#include "app/walk_cost.h"
#include "hal/angle.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"

namespace headway::app {
namespace {

const std::filesystem::path kTree = source_dir();

Robot hrp2() { return read_robot(kTree / "config/hrp2/robot.yaml"); }
sim::World world(const std::string& name) {
  return sim::read_world(kTree / "config/worlds" / (name + ".yaml"));
}

/// A small room with nothing in it: start and goal 1.5 m apart.
sim::World empty_room() {
  sim::World world;
  world.name = "empty";
  sim::add_room(world, {0.5, 0}, {5, 4}, 2.2, 0);
  world.start = {-0.8, 0, 0};
  world.goal = sim::Goal2{{0.7, 0.1}, 0.5};
  return world;
}

SimOptions range_mode(std::uint64_t seed = 1) {
  SimOptions options;
  options.range_mode = true;
  options.seed = seed;
  options.longest = seconds(200);
  return options;
}

TEST(SimSession, WalksToAGoalAndFacesAsWished) {
  SimSession session(hrp2(), empty_room(), range_mode());
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.reason;
  EXPECT_LE(outcome.goal_error, 0.10);
  ASSERT_TRUE(outcome.goal_yaw_error);
  EXPECT_LE(*outcome.goal_yaw_error, 0.1);
  ASSERT_FALSE(session.steps().empty());
  for (const auto& step : session.steps()) EXPECT_LE(step.frame_age, session.robot().steps.max_map_age);
}

TEST(SimSession, WalksInOrdersAsItDoesInSteps) {
  Robot robot = hrp2();
  robot.mission.execution = nav::Execution::kOrders;
  SimSession session(robot, empty_room(), range_mode());
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.end << ": " << outcome.reason;
  EXPECT_EQ(session.bus_loop().counters().plans_refused, 0U);
  const Json report = sim_report(session, outcome);
  EXPECT_GE(report["orders"], 3);
  EXPECT_LT(report["orders"], report["steps"].size());
}

/// The same things, all of them moved together, as seen by a robot at the start.
sim::World moved(sim::World world, const Pose2& seen_by_robot) {
  const Pose2 by = world.start * seen_by_robot * world.start.inverse();
  for (sim::Thing& thing : world.things) {
    thing.solid.pose = by * thing.solid.pose;
  }
  return world;
}

TEST(SimSession, FindsItsPlaceInAMapOfAnEarlierRun) {
  SimOptions options = range_mode();
  options.exact_feet = true;
  SimSession first(hrp2(), world("lab"), options);
  ASSERT_TRUE(first.run().arrived);
  nav::SavedMap known(first.mapper().everything());
  known.surfaces = first.frame_loop().localisation().surfaces();

  // The operator has set the robot up 7 cm and two degrees beside where it began.
  const Pose2 off{0.06, -0.04, 0.035};
  SimSession second(hrp2(), moved(world("lab"), off), options);
  second.restore(known);
  const SimOutcome outcome = second.run();
  EXPECT_NE(outcome.end, "collision") << outcome.reason;
  EXPECT_NE(outcome.end, "stopped") << outcome.reason;
  EXPECT_LT(second.mission().views_taken(), first.mission().views_taken());
  const Pose2 truth = second.body().stance().base(),
              in_map = second.frame_loop().localisation().map_from_odom() *
                       second.links().report.value().committed.stance.base(),
              wanted = world("lab").start * off.inverse() * world("lab").start.inverse() * truth;
  EXPECT_LT((in_map.position() - wanted.position()).norm(), 0.02);
  EXPECT_LT(std::abs(wrap_angle(in_map.yaw - wanted.yaw)), 0.005);
}

TEST(SimSession, WalksNowhereAndSpoilsNothingInAMapThatTheViewsDoNotFit) {
  SimSession first(hrp2(), world("lab"), range_mode());
  ASSERT_TRUE(first.run().arrived);
  nav::SavedMap known(first.mapper().everything());
  known.surfaces = first.frame_loop().localisation().surfaces();

  SimSession second(hrp2(), moved(world("lab"), {0.2, -0.1, 0.8}), range_mode());
  second.restore(known);
  const SimOutcome outcome = second.run();
  EXPECT_EQ(outcome.end, "stopped");
  EXPECT_NE(outcome.reason.find("set the robot up"), std::string::npos) << outcome.reason;
  EXPECT_EQ(outcome.walked, 0);
  EXPECT_TRUE(second.mapper().everything() == known.map);
}

TEST(SimSession, WalksNowhereInAMapOfAnotherRoomHoweverWellItsWallsCanBeMadeToFit) {
  SimSession first(hrp2(), world("moving_box"), range_mode());
  ASSERT_TRUE(first.run().arrived);
  nav::SavedMap known(first.mapper().everything());
  known.surfaces = first.frame_loop().localisation().surfaces();

  SimSession second(hrp2(), world("lab"), range_mode());
  second.restore(known);
  const SimOutcome outcome = second.run();
  EXPECT_EQ(outcome.end, "stopped");
  EXPECT_NE(outcome.reason.find("set the robot up"), std::string::npos) << outcome.reason;
  EXPECT_EQ(outcome.walked, 0);
}

TEST(SimSession, GoesAroundABarTooLowForTheVoxels) {
  sim::World low = world("bar");
  const auto lower = std::ranges::find(low.things, "bar", &sim::Thing::name);
  ASSERT_NE(lower, low.things.end());
  lower->solid = sim::Solid::box({0.2, -0.3, 0.015}, {0.08, 2.2, 0.03});
  for (const sim::World& bar : {world("bar"), low}) {
    const SimOutcome outcome = SimSession(hrp2(), bar, range_mode()).run();
    EXPECT_TRUE(outcome.arrived) << outcome.end << ": " << outcome.reason;
  }
  Robot heedless = hrp2();
  heedless.mapper.raised_floor.trip_height = 0;
  EXPECT_EQ(SimSession(heedless, low, range_mode()).run().end, "collision");
}

std::ptrdiff_t steps_over(const SimSession& session) {
  return std::ranges::count_if(session.steps(),
                               [](const auto& record) { return record.step.step.clear > 0; });
}

TEST(SimSession, StepsOverALowBarWhenItMay) {
  Robot robot = hrp2();
  step_over(0.06, robot);
  SimSession session(robot, world("step_over"), range_mode(7));
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.end << ": " << outcome.reason;
  EXPECT_FALSE(outcome.collision);
  EXPECT_GE(steps_over(session), 2) << "both feet";
  EXPECT_LE(steps_over(session), 6);
  for (const auto& record : session.steps()) {
    EXPECT_TRUE(record.step.step.clear == 0 || record.step.step.duration == robot.mission.gait.over.duration);
  }
}

TEST(SimSession, StopsBeforeALowBarWhenItMayNotStepOverItAndSaysWhy) {
  SimSession session(hrp2(), world("step_over"), range_mode(6));
  const SimOutcome outcome = session.run();
  EXPECT_EQ(outcome.end, "stopped");
  EXPECT_FALSE(outcome.reason.empty());
  EXPECT_EQ(steps_over(session), 0);
}

TEST(SimSession, HasNoYawErrorWhereNoYawIsWished) {
  sim::World world = empty_room();
  world.goal->yaw.reset();
  SimOptions options = range_mode();
  options.longest = seconds(1);
  SimSession session(hrp2(), world, options);
  const SimOutcome outcome = session.run();
  EXPECT_FALSE(outcome.goal_yaw_error);
  EXPECT_TRUE(sim_report(session, outcome)["goal_yaw_error_deg"].is_null());
}

TEST(SimSession, ReportsWhatWasWrongWithTheCamerasSight) {
  const auto findings = [](double least_sharpness) {
    Robot robot = hrp2();
    robot.vision.sight.least_sharpness = least_sharpness;
    SimOptions options = range_mode();
    options.range_mode = false;
    options.longest = seconds(1);
    SimSession session(robot, empty_room(), options);
    return sim_report(session, session.run())["sight_findings"];
  };
  EXPECT_EQ(findings(0), Json::array());
  const Json blurred = findings(10);  // nothing is as sharp
  ASSERT_EQ(blurred.size(), 1U) << "one for all frames";
  EXPECT_EQ(blurred[0]["severity"], "warning");
  EXPECT_NE(blurred[0]["what"].get<std::string>().find("sharp"), std::string::npos) << blurred;
  EXPECT_GE(blurred[0]["frames"], 5);
}

TEST(SimSession, FollowsOdometryThatItIsToldToTrust) {
  SimOptions options = range_mode();
  options.localise = false;
  SimSession session(hrp2(), empty_room(), options);
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.reason;
  EXPECT_EQ(outcome.map_error, outcome.odometry_error);
  const runtime::LocalisationCounters& views = session.frame_loop().localisation().counters();
  EXPECT_EQ(views.whole + views.partly + views.refused, 0U);
}

/// Cells of level floor near the robot's way that its floor map shows as blocked.
std::size_t false_cells(const SimSession& session) {
  return false_obstacles(session.mapper().floor(), session.robot().mapper.obstacle_heights(), session.scene(),
                         {session.trail().truth, SimTrail::kPeriod})
      .floor.size();
}

TEST(SimSession, FindsOutHowFarTheHeadsTiltIsOff) {
  for (const double tilt : {-1.0, 0.5, 1.0}) {
    SimOptions options = range_mode();
    options.tilt_error = tilt * kDegree;
    SimSession session(hrp2(), empty_room(), options);
    const SimOutcome outcome = session.run();
    EXPECT_TRUE(outcome.arrived) << outcome.reason;
    // The view looks higher about its x axis, the head lower about its own.
    EXPECT_NEAR(session.frame_loop().levelling().tilt(), -tilt * kDegree, 0.15 * kDegree);
    EXPECT_EQ(false_cells(session), 0U) << tilt << " deg";
  }
}

TEST(SimSession, TakesTheFloorForAnObstacleWhenItMayNotLevel) {
  Robot robot = hrp2();
  robot.levelling.use = false;
  SimOptions options = range_mode();
  options.tilt_error = 3 * kDegree;
  options.longest = seconds(20);
  SimSession session(robot, empty_room(), options);
  session.run();
  EXPECT_GT(false_cells(session), 0U) << "or there was nothing to level";
}

TEST(SimSessionSlow, ShowsNoObstacleWhereThereIsNoneWhateverTheHeadErrs) {
  for (const bool range : {true, false}) {
    for (const double tilt : {-1.0, 1.0}) {
      SimOptions options = range_mode();
      options.range_mode = range;
      options.tilt_error = tilt * kDegree;
      SimSession session(hrp2(), world("lab"), options);
      const SimOutcome outcome = session.run();
      EXPECT_FALSE(outcome.fallen || outcome.collision) << outcome.reason;
      EXPECT_GT(outcome.walked, 5) << outcome.reason;
      EXPECT_EQ(false_cells(session), 0U) << tilt << " deg, range mode " << range;
    }
  }
}

TEST(SimSessionSlow, KeepsItsPlaceWhileOdometryDrifts) {
  // The seeds draw short and long strides, and swerves to both sides.
  for (const std::uint64_t seed : {4, 5, 6, 7}) {
    SimOptions options = range_mode(seed);
    options.drift = 0.02;
    SimSession session(hrp2(), world("lab"), options);
    const SimOutcome outcome = session.run();
    EXPECT_TRUE(outcome.arrived) << seed << ": " << outcome.reason;
    EXPECT_LE(outcome.goal_error, 0.07) << seed;
    EXPECT_LE(outcome.map_error, 0.06) << seed;
    EXPECT_GE(outcome.odometry_error, 0.15) << seed << ": or there was nothing to find";
    EXPECT_NEAR(session.frame_loop().localisation().drift().stride(), seed % 2 == 1 ? 0.02 : -0.02, 0.01);
  }
}

TEST(SimSessionSlow, WalksAHundredMetresInTheSameMemory) {
  SimOptions options = range_mode();
  options.longest = seconds(1200);
  // Where a straight corridor leads is not a question of memory: a heading that is known to a degree ends 1.7
  // m beside it.
  options.exact_feet = true;
  options.localise = false;
  SimSession session(hrp2(), world("corridor"), options);
  WalkCost cost;
  session.observe([&](const runtime::FrameSnapshot& s) { cost.note(s, session.body().path_walked()); });
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.reason;
  EXPECT_GE(outcome.walked, 99);
  const std::vector<WalkStretch>& stretches = cost.stretches();
  ASSERT_GE(stretches.size(), 9U);
  fmt::print("{}", walk_cost_table(stretches));
  // In the first two stretches the window is not left yet, in the last it stops before the corridor's end.
  const std::size_t first = 2, last = stretches.size() - 2;
  const auto bricks = [&](std::size_t i) { return static_cast<double>(stretches[i].aside_bricks); };
  const double per_stretch = (bricks(last) - bricks(first - 1)) / static_cast<double>(last - first + 1);
  EXPECT_GT(per_stretch, 100) << "or nothing was left behind";
  for (std::size_t i = first; i <= last; ++i) {
    EXPECT_NEAR((bricks(i) - bricks(i - 1)) / per_stretch, 1, 0.2)
        << "the corridor is much the same all along";
    EXPECT_EQ(stretches[i].window_bytes, stretches[0].window_bytes);
    EXPECT_LT(static_cast<double>(stretches[i].aside_bytes) / bricks(i), 700) << "bytes, of 512 voxels";
  }
}

TEST(SimSessionSlow, LooksThroughBothCamerasOnTheWay) {
  SimOptions options = range_mode();
  options.range_mode = false;
  options.longest = seconds(60);
  SimSession session(hrp2(), empty_room(), options);
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.reason;
  EXPECT_GE(session.precision().share(), 0.97) << "points within 3 sigma of the truth";
  EXPECT_LE(session.precision().share(), 0.999)
      << "3 sigma of a Gaussian, not more: bounds are no wider than need be";
  EXPECT_GT(session.precision().points, 100000U);
}

TEST(SimSessionSlow, WalksAroundABoxThatSlidesOntoItsPath) {
  SimSession session(hrp2(), world("moving_box"), range_mode());
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.reason;
  EXPECT_FALSE(outcome.collision);
  EXPECT_FALSE(outcome.fallen);
  EXPECT_LE(outcome.goal_error, 0.10);
  EXPECT_GE(session.mission().counters().replans, 1);
}

TEST(SimSessionSlow, StopsShortOfTheBoxWhenItMayNotReplan) {
  SimOptions options = range_mode();
  options.replan = false;
  SimSession session(hrp2(), world("moving_box"), options);
  const SimOutcome outcome = session.run();
  EXPECT_FALSE(outcome.arrived);
  EXPECT_FALSE(outcome.collision) << "steps commit only onto free floor, replanning or not";
  EXPECT_FALSE(outcome.reason.empty());
}

TEST(SimSession, StaysWhereItIsWhenThereIsNoWayAndSaysWhy) {
  SimSession session(hrp2(), world("blocked"), range_mode());
  const SimOutcome outcome = session.run();
  EXPECT_EQ(outcome.end, "stopped");
  EXPECT_TRUE(outcome.reason.starts_with("no way")) << outcome.reason;
  EXPECT_LT(outcome.walked, 0.01);
}

TEST(SimSessionSlow, WalksAsNearAsItGetsWhenThatWillDo) {
  SimOptions options = range_mode();
  options.near = true;
  SimSession session(hrp2(), world("blocked"), options);
  const SimOutcome outcome = session.run();
  ASSERT_TRUE(outcome.arrived) << outcome.end << ": " << outcome.reason;
  EXPECT_GT(outcome.walked, 1.5);
  // The chamber's walls are 1.05 and 1.1 m from the goal; beside them the body wants 0.28 m or more.
  EXPECT_GT(outcome.short_of_goal, 1.25);
  EXPECT_LT(outcome.short_of_goal, 1.55);
  EXPECT_NEAR(outcome.goal_error, outcome.short_of_goal, kArrivedWithin);
  EXPECT_NE(outcome.reason.find("as near as it gets"), std::string::npos) << outcome.reason;
  EXPECT_EQ(sim_report(session, outcome)["short_of_goal_m"], std::round(outcome.short_of_goal * 1e4) / 1e4);
}

TEST(SimSessionSlow, WalksUpToAnObstacleThatTheGoalLiesIn) {
  SimOptions options = range_mode();
  options.goal = nav::Goal{{-0.6, -1.7}, std::nullopt};  // in the carton
  EXPECT_THROW(SimSession(hrp2(), world("blocked"), options), InputError);
  options.near = true;
  SimSession session(hrp2(), world("blocked"), options);
  const SimOutcome outcome = session.run();
  ASSERT_TRUE(outcome.arrived) << outcome.end << ": " << outcome.reason;
  EXPECT_GT(outcome.short_of_goal, 0.4);
  EXPECT_LT(outcome.short_of_goal, 0.9);
}

TEST(SimSessionSlow, GivesTheSameReportForTheSameSeed) {
  const auto report = [](std::uint64_t seed) {
    SimSession session(hrp2(), empty_room(), range_mode(seed));
    return sim_report(session, session.run()).dump();
  };
  const std::string first = report(7);
  EXPECT_EQ(first, report(7));
  EXPECT_NE(first, report(8));
}

TEST(SimSessionSlow, HasNotArrivedWhenItOnlyBelievesSo) {
  Robot robot = hrp2();
  robot.simulation.body.stride_scale = 0.85;  // walks less far than it counts
  SimOptions options = range_mode();
  options.localise = false;
  SimSession session(robot, empty_room(), options);
  const SimOutcome outcome = session.run();
  EXPECT_FALSE(outcome.arrived);
  EXPECT_EQ(outcome.end, "missed");
  EXPECT_GT(outcome.goal_error, kArrivedWithin);
  EXPECT_NE(outcome.reason.find("believes to be at the goal"), std::string::npos) << outcome.reason;
}

TEST(SimSessionSlow, ArrivesWithStridesMuchShorterThanItCounts) {
  Robot robot = hrp2();
  robot.simulation.body.stride_scale = 0.85;
  SimSession session(robot, empty_room(), range_mode());
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.reason;
  EXPECT_GT(outcome.odometry_error, kArrivedWithin);
}

TEST(SimSessionSlow, WalksInTheStepsThatTheRobotFileAsksFor) {
  Robot robot = hrp2();
  robot.mission.gait.step_duration = seconds(0.6);
  SimSession session(robot, empty_room(), range_mode());
  const SimOutcome outcome = session.run();
  EXPECT_TRUE(outcome.arrived) << outcome.end << ": " << outcome.reason;
  EXPECT_EQ(session.bus_loop().counters().plans_refused, 0U);
}

TEST(SimSessionSlow, ReportsStepsThatWereWalkedAndWhatTheyRestOn) {
  SimSession session(hrp2(), empty_room(), range_mode());
  const Json report = sim_report(session, session.run());
  EXPECT_EQ(report["steps"].back()["index"], session.walker().status().executing)
      << "the last one reported is the last one walked";
  EXPECT_EQ(report["seed"], 1);
  EXPECT_EQ(report["sight"], "range");
  EXPECT_EQ(report["replan"], true);
  EXPECT_EQ(report["bus"]["dropped"]["steps"], 0);
  EXPECT_EQ(report["bus"]["unused"]["wrong_crc"], 0);
  const Pose2 last = session.steps().back().landing;
  EXPECT_LT((last.position() - session.goal().position).norm(), 0.2) << "the prints lead to the goal";
  for (const Json& step : report["steps"]) {
    EXPECT_EQ(step["clear_m"], 0) << "there is nothing to go over";
    EXPECT_EQ(step["seconds"], 0.8);
  }
}

TEST(SimSession, NeedsAGoalOnTheFloor) {
  sim::World nowhere = empty_room();
  nowhere.goal.reset();
  EXPECT_THROW(SimSession(hrp2(), nowhere, range_mode()), InputError);
  SimOptions outside = range_mode();
  outside.goal = nav::Goal{{40, 0}, std::nullopt};
  EXPECT_THROW(SimSession(hrp2(), empty_room(), outside), InputError);
  SimOptions aimless = range_mode();
  aimless.goal = nav::Goal{{0, 0}, std::nan("")};
  EXPECT_THROW(SimSession(hrp2(), empty_room(), aimless), InputError);
}

TEST(SimSession, RendersOnlyLensesThatItKnows) {
  Robot fisheye = hrp2();
  fisheye.rig.right.lens = vision::LensModel::kEquidistant;
  EXPECT_THROW(SimSession(fisheye, empty_room(), SimOptions{}), InputError);
}

}  // namespace
}  // namespace headway::app
