#include "runtime/floor_gate.h"

#include <gtest/gtest.h>

namespace headway::runtime {
namespace {

const nav::GaitLimits kGait;
const nav::BodyOutline kOutline;

/// Free floor from -1 to 5 m along x and +-1 m along y, seen at `seen`.
nav::FloorMap free_floor(Time seen) {
  nav::FloorGrid grid{0.05, {-1, -1}, 120, 40};
  nav::FloorMap floor = nav::unseen_floor(grid);
  std::fill(floor.cells.begin(), floor.cells.end(), nav::Floor::kFree);
  std::fill(floor.seen_at.begin(), floor.seen_at.end(), seen);
  return floor;
}

/// A straight walk from the origin along x.
nav::Walk straight_walk(int steps) {
  nav::Walk walk;
  hal::Stance stance = hal::Stance::parallel({}, kGait.feet_apart);
  walk.from = stance;
  for (int i = 0; i < steps; ++i) {
    const hal::Foot foot = i % 2 ? hal::Foot::kRight : hal::Foot::kLeft;
    const double side = foot == hal::Foot::kLeft ? kGait.feet_apart : -kGait.feet_apart;
    const hal::Footstep step{foot, {0.2, side, 0}, 0, seconds(0.8)};
    stance = stance.after(step);
    walk.steps.push_back(step);
    walk.stances.push_back(stance);
    walk.bases.push_back(nav::gait_base(stance, foot, kGait));
  }
  return walk;
}

void set(nav::FloorMap& floor, double from_x, double to_x, nav::Floor state) {
  for (int y = 0; y < floor.grid.height; ++y)
    for (int x = 0; x < floor.grid.width; ++x) {
      const Eigen::Vector2d centre = floor.grid.centre({x, y});
      if (centre.x() > from_x && centre.x() < to_x) floor.cells[floor.grid.index({x, y})] = state;
    }
}

TEST(FloorGate, OpensEveryStepOntoFloorJustSeen) {
  const FloorGate gate({}, kGait, kOutline);
  const Gate result = gate.check(straight_walk(10), 0, free_floor(at_seconds(5)), {}, at_seconds(6));
  EXPECT_EQ(result.open, 10U);
  EXPECT_FALSE(result.blocked);
  EXPECT_TRUE(result.missing.empty());
}

TEST(FloorGate, ClosesAtTheFirstStepWhoseBodyWouldBeOverUnseenFloor) {
  const FloorGate gate({}, kGait, kOutline);
  nav::FloorMap floor = free_floor(at_seconds(5));
  set(floor, 1.5, 9, nav::Floor::kUnseen);
  const Gate result = gate.check(straight_walk(12), 0, floor, {}, at_seconds(6));
  // The body reaches 0.20 m ahead of its base: bases up to 1.3 m are over seen floor, that is six steps of
  // 0.2 m.
  EXPECT_EQ(result.open, 6U);
  EXPECT_FALSE(result.blocked);
  ASSERT_FALSE(result.missing.empty());
  EXPECT_GT(floor.grid.centre(result.missing.front()).x(), 1.5);
}

TEST(FloorGate, ClosesBeforeAnObstacleAndSaysSo) {
  const FloorGate gate({}, kGait, kOutline);
  nav::FloorMap floor = free_floor(at_seconds(5));
  set(floor, 1.5, 1.7, nav::Floor::kBlocked);
  const Gate result = gate.check(straight_walk(12), 0, floor, {}, at_seconds(6));
  EXPECT_EQ(result.open, 6U);
  EXPECT_TRUE(result.blocked);
}

TEST(FloorGate, ForgetsWhatWasSeenTooLongAgoButNotBeforeTheFeet) {
  FloorGateConfig config;
  config.recent = seconds(4);
  config.blind_radius = 0.8;
  const FloorGate gate(config, kGait, kOutline);
  const Gate result = gate.check(straight_walk(10), 0, free_floor(at_seconds(5)), {}, at_seconds(20));
  EXPECT_GT(result.open, 0U);
  EXPECT_LT(result.open, 4U);
  EXPECT_FALSE(result.missing.empty());
}

TEST(FloorGate, NeverPutsASoleOnUnseenFloorHoweverNear) {
  FloorGateConfig config;
  config.blind_radius = 10;
  const FloorGate gate(config, kGait, kOutline);
  nav::FloorMap floor = free_floor(at_seconds(5));
  set(floor, 0.35, 9, nav::Floor::kUnseen);
  EXPECT_EQ(gate.check(straight_walk(5), 0, floor, {}, at_seconds(6)).open, 1U);
}

TEST(FloorGate, TakesFloorThatIsKnownFromBeforeOnlyForUnseen) {
  const FloorGate gate({}, kGait, kOutline);
  EXPECT_EQ(gate.check(straight_walk(5), 0, free_floor(nav::kNever), {}, at_seconds(6)).open, 0U);
}

TEST(FloorGate, TrustsAnOldLookOnlyAroundWhereTheRobotIsNow) {
  const FloorGate gate({}, kGait, kOutline);
  const nav::FloorMap floor = free_floor(at_seconds(5));
  const nav::Walk walk = straight_walk(10);
  EXPECT_GT(gate.check(walk, 3, floor, walk.bases[2], at_seconds(60)).open, 0U);
  EXPECT_EQ(gate.check(walk, 3, floor, {}, at_seconds(60)).open, 0U) << "0.6 m are committed already";
}

/// A walk that goes over what lies from 1.15 to 1.2 m, with soles well off it on either side.
nav::Walk walk_over() {
  nav::Walk walk = straight_walk(4);
  const auto add = [&](double ahead, double clear) {
    const hal::Foot foot = hal::other(walk.steps.back().foot);
    const double side = foot == hal::Foot::kLeft ? kGait.feet_apart : -kGait.feet_apart;
    const hal::Footstep step{foot, {ahead, side, 0}, 0, seconds(clear > 0 ? 1.4 : 0.8), clear};
    const hal::Stance stance = walk.stances.back().after(step);
    walk.add(step, stance, nav::gait_base(stance, foot, kGait));
  };
  add(0.2, 0);     // to 1 m
  add(0.4, 0.06);  // over, to 1.4 m
  add(0.2, 0.06);  // over, to 1.6 m
  add(0.2, 0);
  add(0, 0);
  return walk;
}

TEST(FloorGate, LetsTheBodyPassOverWhatAFootStepsOver) {
  const FloorGate gate({}, kGait, kOutline);
  nav::FloorMap floor = free_floor(at_seconds(5));
  const nav::Walk walk = walk_over();
  set(floor, 1.15, 1.2, nav::Floor::kLow);
  const Gate result = gate.check(walk, 0, floor, {}, at_seconds(6));
  EXPECT_EQ(result.open, walk.steps.size());
  EXPECT_FALSE(result.blocked);
  EXPECT_TRUE(gate.clear(walk, 0, floor));
  set(floor, 1.15, 1.2, nav::Floor::kBlocked);
  EXPECT_TRUE(gate.check(walk, 0, floor, {}, at_seconds(6)).blocked);
}

TEST(FloorGate, OpensNoStepOntoWhatIsLow) {
  const FloorGate gate({}, kGait, kOutline);
  const nav::Walk walk = walk_over();
  for (std::size_t step = 0; step < walk.steps.size(); ++step) {
    const double x = walk.stances[step].at(walk.steps[step].foot).x;
    nav::FloorMap floor = free_floor(at_seconds(5));
    for (int y = 0; y < floor.grid.height; ++y) {
      const Eigen::Vector2i cell(floor.grid.cell({x, 0}).x(), y);
      floor.cells[floor.grid.index(cell)] = nav::Floor::kLow;
    }
    const Gate result = gate.check(walk, 0, floor, {}, at_seconds(6));
    EXPECT_LE(result.open, step) << x;
    EXPECT_TRUE(result.blocked) << x;
    EXPECT_LE(gate.clear_steps(walk, 0, floor), step);
    EXPECT_TRUE(result.missing.empty()) << "it has been seen";
  }
}

/// What is found to be low once the steps over it are planned.
TEST(FloorGate, OpensNoStepThatGoesOverWhatIsLowAtUsualHeight) {
  const FloorGate gate({}, kGait, kOutline);
  nav::FloorMap floor = free_floor(at_seconds(5));
  set(floor, 1.15, 1.2, nav::Floor::kLow);
  for (const std::size_t low : {5U, 6U}) {
    nav::Walk walk = walk_over();
    walk.steps[low].clear = 0;
    const Gate result = gate.check(walk, 0, floor, {}, at_seconds(6));
    EXPECT_EQ(result.open, low);
    EXPECT_TRUE(result.blocked);
    EXPECT_EQ(gate.clear_steps(walk, 0, floor), low);
    EXPECT_EQ(gate.clear_steps(walk, low + 1, floor), walk.steps.size() - low - 1);
  }
  nav::Walk first = walk_over();
  first.from = first.stances[4];
  first.steps = {first.steps[5]};
  first.stances = {first.stances[5]};
  first.bases = {first.bases[5]};
  EXPECT_TRUE(gate.clear(first, 0, floor));
  first.steps.front().clear = 0;
  EXPECT_FALSE(gate.clear(first, 0, floor)) << "from where the walk begins";
}

TEST(FloorGate, FindsAWalkClearUntilAnObstacleStandsOnItsRest) {
  const FloorGate gate({}, kGait, kOutline);
  nav::FloorMap floor = free_floor(at_seconds(5));
  const nav::Walk walk = straight_walk(10);
  EXPECT_TRUE(gate.clear(walk, 0, floor));
  set(floor, 0.9, 1.0, nav::Floor::kBlocked);
  EXPECT_FALSE(gate.clear(walk, 0, floor));
  EXPECT_TRUE(gate.clear(walk, 8, floor)) << "what lies behind no longer matters";
}

}  // namespace
}  // namespace headway::runtime
