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
  sim::MovingThing cart;
  cart.thing = {"cart", sim::Solid::box({0, -1, 0.3}, {0.3, 0.3, 0.6}), 0};
  cart.starts.value = 1e6;
  cart.path = sim::path_at_speed({{0, -1, 0}, {1, -1, 0}}, 0.5);
  world.moving.push_back(cart);
  return world;
}

enum class Found { kNothing, kFringe, kFromAfar, kFloor };

/// What is found when only this place is blocked, and was seen last by a robot that went from the origin to
/// (0.5, 0) within a second.
Found found_at(double x, double y, Time seen = at_seconds(1)) {
  nav::FloorMap floor = nav::unseen_floor({0.05, {-5, -5}, 200, 200});
  floor.cells[floor.grid.index(floor.grid.cell({x, y}))] = nav::Floor::kBlocked;
  floor.seen_at[floor.grid.index(floor.grid.cell({x, y}))] = seen;
  const sim::Scene scene(world());
  const std::vector<Pose2> way{Pose2{}, Pose2{0.5, 0, 0}};
  const FalseObstacles found = false_obstacles(floor, {}, scene, {way, seconds(1)});
  EXPECT_LE(found.floor.size() + found.from_afar.size() + found.fringe.size(), 1U);
  return !found.floor.empty()       ? Found::kFloor
         : !found.from_afar.empty() ? Found::kFromAfar
         : !found.fringe.empty()    ? Found::kFringe
                                    : Found::kNothing;
}

TEST(FalseObstacles, AreBlockedCellsWithNothingOnThem) {
  EXPECT_EQ(found_at(0.025, 0.025), Found::kFloor);
  EXPECT_EQ(found_at(1.025, 0.025), Found::kNothing) << "the crate";
  EXPECT_EQ(found_at(1.275, 0.025), Found::kNothing) << "within two cells of it";
  EXPECT_EQ(found_at(1.375, 0.025), Found::kFringe) << "its blurred edge";
  EXPECT_EQ(found_at(1.525, 0.025), Found::kFloor) << "beyond";
  EXPECT_EQ(found_at(0.575, -1.025), Found::kNothing) << "where the cart may have been";
  EXPECT_EQ(found_at(-1.025, 0.025), Found::kFloor) << "under what hangs above all heads";
  EXPECT_EQ(found_at(0.025, 1.025), Found::kFloor) << "on what is so low that it counts as floor";
}

TEST(FalseObstacles, CountNearTheRobotsWayAndOnTheWorldsFloorOnly) {
  EXPECT_EQ(found_at(3.475, 0.025), Found::kFloor);
  EXPECT_EQ(found_at(3.575, 0.025), Found::kNothing);
  EXPECT_EQ(found_at(-2.975, 0.025, at_seconds(0.5)), Found::kFloor);
  EXPECT_EQ(found_at(-2.975, 0.025, at_seconds(1)), Found::kFromAfar) << "3.5 m away by then";
  EXPECT_EQ(found_at(-2.975, 0.025, at_seconds(99)), Found::kFromAfar) << "where it stays";
  EXPECT_EQ(found_at(-3.075, 0.025), Found::kNothing);
}

}  // namespace
}  // namespace headway::app
