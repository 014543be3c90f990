#include "nav/floor_map.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "nav/explored.h"
#include "nav/integrate.h"
#include "synthetic_room.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d, Eigen::Vector2i, Eigen::Vector3d;
using Index = VoxelMap::Index;

VoxelMap small_map() {
  VoxelMapConfig config;
  config.lowest = {-0.8, -0.4, -0.4};
  config.highest = {0.8, 0.8, 2.4};
  return VoxelMap(config);
}

/// An occupied floor under the whole map, and air above it.
VoxelMap empty_hall() {
  VoxelMap map = small_map();
  for (int y = 0; y < map.size().y(); ++y) {
    for (int x = 0; x < map.size().x(); ++x) {
      map.see_floor(x, y, at_seconds(1));
      for (int z = 0; z < map.size().z(); ++z) {
        const double height = map.centre({0, 0, z}).z();
        if (height > -0.05) map.set({x, y, z}, height < 0.03 ? LogOdds{70} : LogOdds{-40}, at_seconds(1));
      }
    }
  }
  return map;
}

void occupy(VoxelMap& map, const Vector3d& point, LogOdds value) {
  map.set(map.index(point), value, at_seconds(2));
}

Floor floor_at(const FloorMap& floor, double x, double y) { return floor.at(floor.grid.cell({x, y})); }

/// The definition, cell by cell, straight from the voxels.
Floor by_definition(const VoxelMap& map, const FloorMapConfig& config, int x, int y) {
  const auto obstacles = [&](int i, int j, LogOdds least) {
    int count = 0;
    for (int z = 0; z < map.size().z(); ++z) {
      const double height = map.centre({i, j, z}).z();
      const bool counts = height > config.floor_tolerance && height < config.body_height;
      count += counts && map.at({i, j, z}) == Voxel::kOccupied && map.value({i, j, z}) >= least;
    }
    return count;
  };
  int around = 0;
  for (int j = y - 1; j <= y + 1; ++j) {
    for (int i = x - 1; i <= x + 1; ++i) around += obstacles(i, j, log_odds::kOccupied);
  }
  if (obstacles(x, y, config.strong) > 0) return Floor::kBlocked;
  if (obstacles(x, y, log_odds::kOccupied) > 0 && around >= config.voxels_to_block) return Floor::kBlocked;
  for (int z = 0; z < map.size().z(); ++z) {
    if (std::abs(map.centre({x, y, z}).z()) <= 0.1 && map.at({x, y, z}) == Voxel::kOccupied)
      return Floor::kFree;
  }
  return Floor::kUnseen;
}

RC_GTEST_PROP(FloorMap, IsWhatItsDefinitionSays, ()) {
  VoxelMap map = small_map();
  const int voxels = *rc::gen::inRange(0, 1500);
  for (int k = 0; k < voxels; ++k) {
    const Index i(*rc::gen::inRange(0, 12), *rc::gen::inRange(0, 12), *rc::gen::inRange(0, map.size().z()));
    map.edit(map.brick_index(
        {i.x() / 8, i.y() / 8,
         i.z() / 8}))[static_cast<std::size_t>(VoxelMap::in_brick(i.x() % 8, i.y() % 8, i.z() % 8))] =
        static_cast<LogOdds>(*rc::gen::inRange(-40, 71));
  }
  for (std::size_t b = 0; b < map.brick_count(); ++b) map.settle(b, at_seconds(1));
  FloorMapConfig config;
  config.voxels_to_block = *rc::gen::inRange(1, 5);
  config.floor_tolerance = *rc::gen::element(0.0, 0.08, 0.2);
  const FloorMap floor = floor_map(map, config);
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x)
      RC_ASSERT(floor.at({x, y}) == by_definition(map, config, x, y));
  }
}

RC_GTEST_PROP(FloorGrid, FindsEachCellByItsCentre, ()) {
  const FloorGrid grid{0.05, {-1.35, 0.4}, 40, 30};
  const Vector2i cell(*rc::gen::inRange(-5, 45), *rc::gen::inRange(-5, 35));
  RC_ASSERT(grid.cell(grid.centre(cell)) == cell);
  RC_ASSERT(grid.contains(cell) == (cell.x() >= 0 && cell.x() < 40 && cell.y() >= 0 && cell.y() < 30));
}

TEST(FloorMap, LiesOnTheVoxelMapsColumns) {
  const VoxelMap map = small_map();
  const FloorMap floor = floor_map(map);
  for (const Index& i : {Index(0, 0, 0), Index(5, 9, 3), Index(31, 23, 0)}) {
    EXPECT_TRUE(floor.grid.centre(i.head<2>()).isApprox(map.centre(i).head<2>(), 1e-12));
  }
  EXPECT_EQ(floor.grid.width, map.size().x());
  EXPECT_EQ(floor.grid.height, map.size().y());
}

TEST(FloorMap, IsFreeWhereOnlyFloorWasSeenAndUnseenWhereNothingWas) {
  const FloorMap hall = floor_map(empty_hall());
  for (const Floor f : hall.cells) EXPECT_EQ(f, Floor::kFree);
  EXPECT_EQ(hall.seen({3, 3}), at_seconds(1));
  const FloorMap nothing = floor_map(small_map());
  for (const Floor f : nothing.cells) EXPECT_EQ(f, Floor::kUnseen);
  EXPECT_EQ(nothing.seen({3, 3}), kNever);
  EXPECT_EQ(nothing.at({-1, 3}), Floor::kUnseen);
  EXPECT_EQ(nothing.seen({-1, 3}), kNever);
}

TEST(FloorMap, TakesWhatIsLowOrAboveTheHeadForNoObstacle) {
  VoxelMap map = empty_hall();
  occupy(map, {0.125, 0.125, 0.075}, 70);
  occupy(map, {0.325, 0.125, 1.725}, 70);
  occupy(map, {-0.125, 0.125, 0.125}, 70);
  occupy(map, {-0.325, 0.125, 1.675}, 70);
  const FloorMap floor = floor_map(map);
  EXPECT_EQ(floor_at(floor, 0.125, 0.125), Floor::kFree);
  EXPECT_EQ(floor_at(floor, 0.325, 0.125), Floor::kFree);
  EXPECT_EQ(floor_at(floor, -0.125, 0.125), Floor::kBlocked);
  EXPECT_EQ(floor_at(floor, -0.325, 0.125), Floor::kBlocked);
}

TEST(FloorMap, IgnoresALoneWeakVoxelAndTakesTwoOrASureOne) {
  VoxelMap map = empty_hall();
  occupy(map, {0.125, 0.125, 0.8}, 17);
  EXPECT_EQ(floor_at(floor_map(map), 0.125, 0.125), Floor::kFree);
  occupy(map, {0.175, 0.125, 0.4}, 17);  // a second one in the neighbouring column
  EXPECT_EQ(floor_at(floor_map(map), 0.125, 0.125), Floor::kBlocked);
  EXPECT_EQ(floor_at(floor_map(map), 0.175, 0.125), Floor::kBlocked);
  occupy(map, {0.525, 0.525, 0.8}, 34);
  EXPECT_EQ(floor_at(floor_map(map), 0.525, 0.525), Floor::kBlocked);
}

TEST(FloorMap, DoesNotTakeAHoleForFloor) {
  VoxelMap map = empty_hall();
  for (const double z : {-0.075, -0.025, 0.025, 0.075}) occupy(map, {0.125, 0.125, z}, -40);
  EXPECT_EQ(floor_at(floor_map(map), 0.125, 0.125), Floor::kUnseen);
}

TEST(FloorMap, ShowsAFurnishedRoomAsItIs) {
  VoxelMapConfig config;
  config.lowest = {-2.8, -2.8, -0.4};
  config.highest = {2.8, 2.8, 2.8};
  VoxelMap map(config);
  const auto room = SyntheticRoom::furnished();
  Integrator integrator;
  for (int k = 0; k < 24; ++k) {
    const auto pose = camera_pose({-1.4, 0, 1.4}, -0.9 + 0.3 * (k % 8), 0.1 + 0.35 * (k / 8));
    const Noise noise{
        .disparity_sigma = 0.15, .correlation = 2, .outliers = 0.005, .seed = static_cast<std::uint64_t>(k)};
    integrator.integrate(map, look(room, camera_of(170, 240, 0.6), pose, noise, 0.15), pose, at_seconds(k));
  }
  const FloorMap floor = floor_map(map);
  EXPECT_EQ(floor_at(floor, 1.24, 0.1), Floor::kBlocked) << "table's front edge";
  EXPECT_EQ(floor_at(floor, 0.82, -1.6), Floor::kBlocked) << "crate";
  EXPECT_EQ(floor_at(floor, 1.1, 1.43), Floor::kBlocked) << "pole";
  EXPECT_EQ(floor_at(floor, 0.5, 0), Floor::kFree);
  EXPECT_EQ(floor_at(floor, 0.2, -0.5), Floor::kFree);
  EXPECT_EQ(floor_at(floor, -1.4, 0), Floor::kUnseen) << "where the robot stands";
  EXPECT_EQ(floor_at(floor, 1.3, -1.6), Floor::kBlocked) << "the crate's top";
  EXPECT_EQ(floor_at(floor, 2.4, -1.6), Floor::kUnseen) << "behind the crate";
  int wrong = 0;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      const Vector2d p = floor.grid.centre({x, y});
      double clearance = 9;
      for (double z = 0.15; z < 1.7; z += 0.05)
        clearance = std::min(clearance, room.clearance({p.x(), p.y(), z}));
      wrong += clearance > 0.15 && floor.at({x, y}) == Floor::kBlocked;
      wrong += clearance < -0.03 && std::abs(p.x()) < 2.5 && std::abs(p.y()) < 2.3 &&
               floor.at({x, y}) == Floor::kFree;
    }
  }
  EXPECT_LE(wrong, 3);
}

TEST(StartArea, CountsUnseenFloorAroundTheStartAsFreeAndLeavesTheRest) {
  FloorMap floor = unseen_floor({0.05, {-2, -2}, 80, 80});
  const auto put = [&](double x, double y, Floor f) {
    floor.cells[floor.grid.index(floor.grid.cell({x, y}))] = f;
  };
  put(0.51, 0.01, Floor::kBlocked);
  put(0.01, 0.01, Floor::kBlocked);  // under the robot: its own legs
  put(-0.5, 0.3, Floor::kFree);
  put(-0.5, -0.3, Floor::kFree);
  floor.seen_at[floor.grid.index(floor.grid.cell({-0.5, -0.3}))] = at_seconds(6);
  start_clear(floor, {0, 0, 0.7}, {.radius = 0.8, .footprint_half = {0.15, 0.2}}, at_seconds(4));
  EXPECT_EQ(floor_at(floor, 0.51, 0.01), Floor::kBlocked) << "evidence counts";
  EXPECT_EQ(floor_at(floor, 0.01, 0.01), Floor::kFree) << "the robot stands there";
  EXPECT_EQ(floor_at(floor, 0.3, 0.3), Floor::kFree);
  EXPECT_EQ(floor.seen(floor.grid.cell({0.3, 0.3})), at_seconds(4));
  EXPECT_EQ(floor.seen(floor.grid.cell({-0.5, 0.3})), at_seconds(4))
      << "known from before, and vouched for now";
  EXPECT_EQ(floor.seen(floor.grid.cell({-0.5, -0.3})), at_seconds(6)) << "seen since";
  EXPECT_EQ(floor_at(floor, 0.9, 0.3), Floor::kUnseen);
}

TEST(StartArea, FreesNothingThatIsBlockedOnceTheRobotHasLeft) {
  FloorMap floor = unseen_floor({0.05, {-2, -2}, 80, 80});
  floor.cells[floor.grid.index(floor.grid.cell({0.01, 0.01}))] = Floor::kBlocked;
  start_clear(floor, {0, 0, 0}, {}, at_seconds(4), false);
  EXPECT_EQ(floor_at(floor, 0.01, 0.01), Floor::kBlocked);
  EXPECT_EQ(floor_at(floor, 0.06, 0.01), Floor::kFree) << "the operator still vouches for what is unseen";
}

TEST(StartArea, EndsAtAWall) {
  FloorMap floor = unseen_floor({0.05, {-2, -2}, 80, 80});
  for (int y = 0; y < 80; ++y) floor.cells[floor.grid.index({50, y})] = Floor::kBlocked;  // x from 0.50
  start_clear(floor, {}, {}, at_seconds(4));
  EXPECT_EQ(floor_at(floor, 0.48, 0.3), Floor::kFree);
  EXPECT_EQ(floor_at(floor, 0.58, 0.01), Floor::kUnseen);
  EXPECT_EQ(floor.seen(floor.grid.cell({0.58, 0.01})), kNever);
}

RC_GTEST_PROP(StartArea, NeverFreesBlockedFloorOutsideOfTheFootprint, ()) {
  FloorMap floor = unseen_floor({0.05, {-2, -2}, 80, 80});
  for (auto& cell : floor.cells) cell = Floor::kBlocked;
  const Pose2 start{*rc::gen::inRange(-250, 250) / 100.0, *rc::gen::inRange(-250, 250) / 100.0,
                    *rc::gen::inRange(-314, 314) / 100.0};
  const StartArea area;
  start_clear(floor, start, area, at_seconds(1));
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 80; ++x) {
      const Vector2d p = start.inverse() * floor.grid.centre({x, y});
      const bool inside =
          std::abs(p.x()) <= area.footprint_half.x() && std::abs(p.y()) <= area.footprint_half.y();
      RC_ASSERT((floor.at({x, y}) == Floor::kFree) == inside);
    }
  }
}

TEST(Explored, AddsUpToTheWhole) {
  VoxelMap map = empty_hall();
  occupy(map, {0.1, 0.1, 0.8}, 70);
  const ExploredSpace space = explored(map);
  const Vector3d box = map.highest() - map.lowest();
  EXPECT_NEAR(space.occupied + space.empty + space.unseen, box.prod(), 1e-9);
  const double floor_area = box.x() * box.y();
  EXPECT_NEAR(space.occupied, floor_area * 0.1 + 0.05 * 0.05 * 0.05, 1e-9);
  const ExploredFloor area = explored(floor_map(map));
  EXPECT_NEAR(area.blocked, 0.0025, 1e-9);
  EXPECT_NEAR(area.free, floor_area - 0.0025, 1e-9);
  EXPECT_NEAR(area.unseen, 0, 1e-9);
}

TEST(FloorMapConfig, RefusesWhatMakesNoSense) {
  const VoxelMap map = small_map();
  FloorMapConfig config;
  config.floor_tolerance = -1;
  EXPECT_THROW(floor_map(map, config), InputError);
  config = {};
  config.body_height = 0.01;
  EXPECT_THROW(floor_map(map, config), InputError);
  config = {};
  config.voxels_to_block = 0;
  EXPECT_THROW(floor_map(map, config), InputError);
}

}  // namespace
}  // namespace headway::nav
