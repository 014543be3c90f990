#include "app/false_obstacles.h"

#include <gtest/gtest.h>

namespace headway::app {
namespace {

using Eigen::Vector2d, Eigen::Vector2i;

/// A floor of 8 m by 8 m with a crate, and a lamp above all heads.
sim::World world() {
  sim::World world;
  world.floor.size = {8, 8};
  world.things.push_back({"crate", sim::Solid::box({1, 0, 0.3}, {0.4, 0.4, 0.6}), 0});
  world.things.push_back({"lamp", sim::Solid::box({-1, 0, 2.2}, {0.4, 0.4, 0.2}), 0});
  world.things.push_back({"mat", sim::Solid::box({0, 1, 0.02}, {0.4, 0.4, 0.04}), 0});
  return world;
}

enum class Found { kNothing, kFringe, kFloor };

/// What is found when only this place is blocked, by a robot that went from the origin to (0.5, 0).
Found found_at(double x, double y) {
  nav::FloorMap floor = nav::unseen_floor({0.05, {-5, -5}, 200, 200});
  floor.cells[floor.grid.index(floor.grid.cell({x, y}))] = nav::Floor::kBlocked;
  const sim::Scene scene(world());
  const FalseObstacles found = false_obstacles(floor, {}, scene, {Pose2{}, Pose2{0.5, 0, 0}});
  EXPECT_LE(found.floor.size() + found.fringe.size(), 1U);
  return !found.floor.empty() ? Found::kFloor : !found.fringe.empty() ? Found::kFringe : Found::kNothing;
}

TEST(FalseObstacles, AreBlockedCellsWithNothingOnThem) {
  EXPECT_EQ(found_at(0.025, 0.025), Found::kFloor);
  EXPECT_EQ(found_at(1.025, 0.025), Found::kNothing) << "the crate";
  EXPECT_EQ(found_at(1.275, 0.025), Found::kNothing) << "within two cells of it";
  EXPECT_EQ(found_at(1.375, 0.025), Found::kFringe) << "its blurred edge";
  EXPECT_EQ(found_at(1.525, 0.025), Found::kFloor) << "beyond";
  EXPECT_EQ(found_at(-1.025, 0.025), Found::kFloor) << "under what hangs above all heads";
  EXPECT_EQ(found_at(0.025, 1.025), Found::kFloor) << "on what is so low that it counts as floor";
}

TEST(FalseObstacles, CountNearTheRobotsWayAndOnTheWorldsFloorOnly) {
  EXPECT_EQ(found_at(3.475, 0.025), Found::kFloor);
  EXPECT_EQ(found_at(3.575, 0.025), Found::kNothing);
  EXPECT_EQ(found_at(-2.975, 0.025), Found::kFloor);
  EXPECT_EQ(found_at(-3.075, 0.025), Found::kNothing);
}

}  // namespace
}  // namespace headway::app
