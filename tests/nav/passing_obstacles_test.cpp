// What was seen standing on which cell, and when; and where the floor was free before.
#include "nav/passing_obstacles.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/nav/random_floor.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d, Eigen::Vector2i, Eigen::Vector3d;

/// From 3 m above the origin straight down on a box of the given height on the floor, 0.3 m to a side.
vision::RangeView box_from_above(const Vector2d& box, double height) {
  vision::RangeView view;
  view.camera = {160, 120, 120, 79.5, 59.5};
  view.near = 0.3;
  view.far = 6;
  view.depth.assign(160 * 120, 3.0F);
  view.sigma_depth.assign(160 * 120, 0.002F);
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Vector3d on_top = view.camera.point(u, v, 3 - height);
      if ((Vector2d(on_top.x(), -on_top.y()) - box).lpNorm<Eigen::Infinity>() < 0.15)
        view.depth[view.index(u, v)] = static_cast<float>(3 - height);
    }
  }
  return view;
}

Eigen::Isometry3d from_above() {
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  map_from_camera.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  map_from_camera.translation().z() = 3;
  return map_from_camera;
}

const FloorGrid kAround{0.05, {-1, -1}, 40, 40};

TEST(PassingObstacles, StandWhereTheNewestLookThatShowedThemHasObstacles) {
  const FloorMapConfig heights;
  PassingObstacles passing(kAround, heights);
  passing.look(box_from_above({0.4, -0.3}, 0.5), from_above(), at_seconds(1));
  passing.look(box_from_above({-0.4, 0.3}, 0.5), from_above(), at_seconds(2));
  passing.look(box_from_above({0, 0}, heights.floor_tolerance - 0.01), from_above(), at_seconds(3));
  passing.look(box_from_above({0, 0}, heights.body_height + 0.01), from_above(), at_seconds(4));
  int stand = 0;
  for (int y = 0; y < kAround.height; ++y) {
    for (int x = 0; x < kAround.width; ++x) {
      const Vector2d at = kAround.centre({x, y});
      const auto off = [&](const Vector2d& box) { return (at - box).lpNorm<Eigen::Infinity>(); };
      const Time stood = passing.stood_at(kAround.index({x, y}));
      const double to_first = off({0.4, -0.3}), to_second = off({-0.4, 0.3});
      if (std::abs(std::min(to_first, to_second) - 0.15) < 0.03) continue;  // at its border
      const Time expected = to_first < 0.15 ? at_seconds(1) : to_second < 0.15 ? at_seconds(2) : kNever;
      EXPECT_EQ(stood, expected) << at.transpose();
      stand += stood != kNever;
    }
  }
  EXPECT_GT(stand, 30);
}

TEST(PassingObstacles, DoNotStandWhereTwoPointsAreWrong) {
  PassingObstacles passing(kAround, {});
  vision::RangeView view = box_from_above({0, 0}, 0);
  view.depth[view.index(80, 60)] = view.depth[view.index(81, 60)] = 2.5F;
  passing.look(view, from_above(), at_seconds(1));
  for (std::size_t i = 0; i < kAround.size(); ++i) EXPECT_EQ(passing.stood_at(i), kNever);
}

TEST(PassingObstacles, RememberWhereTheFloorWasFree) {
  Dice dice(7);
  PassingObstacles passing(free_floor(30, 20, 0.05).grid, {});
  std::vector<std::uint8_t> was_free(30 * 20, 0);
  for (int i = 0; i < 3; ++i) {
    FloorMap floor = random_floor(30, 20, 0.05, dice);
    fill(floor, {dice.whole(0, 20), 0}, {30, 20}, Floor::kBlocked);
    passing.see(floor);
    for (std::size_t k = 0; k < was_free.size(); ++k) was_free[k] |= floor.cells[k] == Floor::kFree;
  }
  const FloorGrid grid = free_floor(30, 20, 0.05).grid;
  int amid = 0;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 30; ++x) {
      bool all = true;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          all &= grid.contains({x + dx, y + dy}) && was_free[grid.index({x + dx, y + dy})];
      ASSERT_EQ(passing.was_free(grid.index({x, y})), was_free[grid.index({x, y})] != 0);
      ASSERT_EQ(passing.amid_free(grid.centre({x, y})), all);
      amid += all;
    }
  }
  EXPECT_GT(amid, 50);
  EXPECT_GT(std::count(was_free.begin(), was_free.end(), 0), 0);
}

}  // namespace
}  // namespace headway::nav
