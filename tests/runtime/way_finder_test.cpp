#include "runtime/way_finder.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "nav/body_outline.h"
#include "nav/low_ahead.h"

namespace headway::runtime {
namespace {

using Eigen::Vector2d;

/// Free floor, 6 by 5 m around its middle, with something low from -1 to 1.5 m along y and `depth` deep,
/// 0.6 m ahead of the origin.
nav::FloorMap hall_with_bar(double depth) {
  nav::FloorMap floor = nav::unseen_floor({0.05, {-3, -2.5}, 120, 100});
  std::fill(floor.cells.begin(), floor.cells.end(), nav::Floor::kFree);
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      const Vector2d c = floor.grid.centre({x, y});
      if (c.x() > 0.6 && c.x() < 0.6 + depth && c.y() > -1 && c.y() < 1.5)
        floor.cells[floor.grid.index({x, y})] = nav::Floor::kLow;
    }
  }
  return floor;
}

nav::GaitLimits stepping_over() {
  nav::GaitLimits gait;
  gait.over.height = 0.06;
  return gait;
}

struct Found {
  bool goes_over = false, goes_around = false, treads = false;
};

/// The way from the origin to 2 m ahead.
Found find(const nav::FloorMap& floor) {
  const nav::GaitLimits gait = stepping_over();
  WayFinder ways({}, gait, {}, nav::Execution::kSteps, floor.grid);
  nav::Committed committed;
  committed.stance = hal::Stance::parallel({}, gait.feet_apart);
  const nav::Goal goal{{2, 0}, std::nullopt};
  const Way way = ways.find(floor, committed, goal);
  EXPECT_TRUE(way.plan);
  EXPECT_FALSE(way.walk.treads_on_low);
  EXPECT_FALSE(way.walk.steps.empty());
  if (way.walk.steps.empty()) return {};
  EXPECT_LT((way.walk.stances.back().base().position() - goal.position).norm(), 0.1);
  Found found;
  for (const Pose2& base : way.walk.bases) found.goes_around |= std::abs(base.y) > 1;
  for (std::size_t i = 0; i < way.walk.steps.size(); ++i) {
    found.goes_over |= way.walk.steps[i].clear > 0;
    found.treads |= nav::is_on_low(floor, gait, way.walk.stances[i].at(way.walk.steps[i].foot));
  }
  return found;
}

TEST(WayFinder, GoesOverWhatFeetStepOver) {
  const Found found = find(hall_with_bar(0.05));
  EXPECT_TRUE(found.goes_over);
  EXPECT_FALSE(found.goes_around);
  EXPECT_FALSE(found.treads);
}

TEST(WayFinder, GoesAroundWhatNoFeetStepOver) {
  const Found found = find(hall_with_bar(0.25));
  EXPECT_FALSE(found.goes_over);
  EXPECT_TRUE(found.goes_around);
  EXPECT_FALSE(found.treads);
}

TEST(WayFinder, KnowsThatAWayLeadsWhereFeetStepOver) {
  nav::FloorMap floor = hall_with_bar(0.05);
  for (int y = 0; y < floor.grid.height; ++y)
    floor.cells[floor.grid.index({floor.grid.cell({0.625, 0}).x(), y})] = nav::Floor::kLow;
  const nav::GaitLimits gait = stepping_over();
  WayFinder ways({}, gait, {}, nav::Execution::kSteps, floor.grid);
  const nav::Goal goal{{2, 0}, std::nullopt};
  nav::Committed committed;
  committed.stance = hal::Stance::parallel({}, gait.feet_apart);
  EXPECT_TRUE(ways.leads(floor, committed, goal));
  std::ranges::replace(floor.cells, nav::Floor::kLow, nav::Floor::kBlocked);
  EXPECT_FALSE(ways.leads(floor, committed, goal));
}

TEST(WayFinder, FindsNoneWhereNoFeetStepOverFromWallToWall) {
  nav::FloorMap floor = hall_with_bar(0.05);
  for (int y = 0; y < floor.grid.height; ++y)
    for (double x = 0.625; x < 0.85; x += 0.05)
      floor.cells[floor.grid.index({floor.grid.cell({x, 0}).x(), y})] = nav::Floor::kLow;
  const nav::GaitLimits gait = stepping_over();
  WayFinder ways({}, gait, {}, nav::Execution::kSteps, floor.grid);
  nav::Committed committed;
  committed.stance = hal::Stance::parallel({}, gait.feet_apart);
  const Way way = ways.find(floor, committed, {{2, 0}, std::nullopt});
  EXPECT_FALSE(way.plan);
  EXPECT_TRUE(way.walk.steps.empty());
}

}  // namespace
}  // namespace headway::runtime
