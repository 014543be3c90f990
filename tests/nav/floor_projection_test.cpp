#include "nav/floor_projection.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "attic.h"
#include "hal/error.h"
#include "nav/integrate.h"
#include "synthetic_room.h"
#include "tests/heap_count.h"

namespace headway::nav {
namespace {

using Eigen::Vector2i, Eigen::Vector3d;
using Index = VoxelMap::Index;

VoxelMapConfig window() {
  VoxelMapConfig config;
  config.resolution = 0.1;
  config.lowest = {-1.6, -1.6, -0.8};
  config.highest = {1.6, 2.4, 1.6};
  return config;
}

/// Voxels near the middle, so that neighbours meet.
void change_some(VoxelMap& map, int most, Time stamp) {
  const int changes = *rc::gen::inRange(0, most);
  for (int k = 0; k < changes; ++k) {
    const Index i(*rc::gen::inRange(0, map.size().x()), *rc::gen::inRange(10, 22),
                  *rc::gen::inRange(0, map.size().z()));
    map.set(i, static_cast<LogOdds>(*rc::gen::element(-128, -40, 5, 20, 70)), stamp);
    if (*rc::gen::arbitrary<bool>()) map.see_floor(i.x(), i.y(), stamp);
  }
}

/// The cells of `part`'s grid in a larger floor.
void expect_part(const FloorMap& part, const FloorMap& whole) {
  for (int y = 0; y < part.grid.height; ++y) {
    for (int x = 0; x < part.grid.width; ++x) {
      const Vector2i there = whole.grid.cell(part.grid.centre({x, y}));
      RC_ASSERT(whole.at(there) == part.at({x, y}));
      RC_ASSERT(whole.seen(there) >= part.seen({x, y}));
    }
  }
}

RC_GTEST_PROP(FloorProjection, IsTheWholeMapsFloorAfterAnyChanges, ()) {
  VoxelMap map(window());
  FloorMapConfig config;
  config.voxels_to_block = *rc::gen::inRange(1, 4);
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection projection(floor.grid, config);
  for (int update = 0; update < 6; ++update) {
    change_some(map, 60, at_seconds(update));
    projection.update(map, floor);
    const FloorMap whole = floor_map(map, config);
    RC_ASSERT(floor.cells == whole.cells);
    RC_ASSERT(floor.seen_at == whole.seen_at);
  }
}

RC_GTEST_PROP(FloorProjection, FollowsTheWindowOverALargerFloor, ()) {
  VoxelMap map(window());
  Attic attic;
  FloorMap floor = unseen_floor({0.1, {-8, -8}, 160, 160});
  FloorProjection projection(floor.grid);
  VoxelMapConfig everything = window();
  everything.lowest.head<2>().setConstant(-8);
  everything.highest.head<2>().setConstant(8);
  VoxelMap all(everything);  // the same voxels in a window that need not move
  for (int move = 0; move < 5; ++move) {
    change_some(map, 60, at_seconds(move));
    projection.update(map, floor);
    for (std::size_t b = 0; b < map.brick_count(); ++b) {
      const Index at = map.brick_at(b) + (map.first_key() - all.first_key()) / kBrickEdge;
      std::ranges::copy(map.values(b), all.edit(all.brick_index(at)).begin());
      all.settle(all.brick_index(at), at_seconds(move));
    }
    RC_ASSERT(floor.cells == floor_map(all).cells);
    map.roll_to({*rc::gen::inRange(-50, 50) * 0.1, *rc::gen::inRange(-50, 50) * 0.1, 0.4}, &attic);
  }
}

RC_GTEST_PROP(FloorProjection, ForgetsWithTheWindow, ()) {
  VoxelMap map(window());
  FloorMap floor = unseen_floor({0.1, {-8, -8}, 160, 160});
  FloorProjection projection(floor.grid);
  for (int move = 0; move < 5; ++move) {
    change_some(map, 60, at_seconds(move));
    if (*rc::gen::arbitrary<bool>()) projection.update(map, floor);
    map.roll_to({*rc::gen::inRange(-30, 30) * 0.1, *rc::gen::inRange(-30, 30) * 0.1, 0.4}, nullptr);
    change_some(map, 20, at_seconds(move));
    projection.update(map, floor);
    // The outermost cells may have neighbours that are remembered outside of the window.
    FloorMap inside = floor_map(map), whole = floor;
    for (int y = 0; y < inside.grid.height; ++y) {
      for (int x = 0; x < inside.grid.width; ++x) {
        if (x > 0 && y > 0 && x + 1 < inside.grid.width && y + 1 < inside.grid.height) continue;
        inside.cells[inside.grid.index({x, y})] = Floor::kUnseen;
        whole.cells[whole.grid.index(whole.grid.cell(inside.grid.centre({x, y})))] = Floor::kUnseen;
      }
    }
    expect_part(inside, whole);
  }
}

TEST(FloorProjection, LooksOnlyIntoColumnsThatHaveChanged) {
  VoxelMap map(window());
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection projection(floor.grid);
  projection.update(map, floor);
  EXPECT_EQ(projection.columns_looked_into(), 0U);
  map.set({3, 3, 12}, 70, at_seconds(1));
  map.set({3, 3, 20}, 70, at_seconds(1));
  map.set({30, 3, 12}, 70, at_seconds(1));
  projection.update(map, floor);
  EXPECT_EQ(projection.columns_looked_into(), 2U);
  projection.update(map, floor);
  EXPECT_EQ(projection.columns_looked_into(), 0U);
}

TEST(FloorProjection, NoticesAChangeWithTheStampOfTheOneBefore) {
  VoxelMap map(window());
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection projection(floor.grid);
  map.set({3, 3, 15}, 70, at_seconds(1));
  projection.update(map, floor);
  ASSERT_EQ(floor.at({3, 3}), Floor::kBlocked);
  map.set({3, 3, 15}, -40, at_seconds(1));
  projection.update(map, floor);
  EXPECT_EQ(floor.at({3, 3}), Floor::kUnseen);
}

TEST(FloorProjection, DecidesCellsAgainThatSomeoneWroteOver) {
  VoxelMap map(window());
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection projection(floor.grid);
  map.set({3, 3, 15}, 70, at_seconds(1));
  projection.update(map, floor);
  floor.cells[floor.grid.index({3, 3})] = Floor::kFree;
  projection.update(map, floor);
  EXPECT_EQ(floor.at({3, 3}), Floor::kFree) << "nobody told of it";
  projection.again({Vector2i(-5, 2), Vector2i(4, 900)});
  projection.update(map, floor);
  EXPECT_EQ(floor.at({3, 3}), Floor::kBlocked);
}

TEST(FloorProjection, FollowsViewsAsTheWholeMapDoes) {
  VoxelMapConfig config;
  config.lowest = {-2.8, -2.8, -0.4};
  config.highest = {2.8, 2.8, 2.8};
  VoxelMap map(config);
  const auto room = SyntheticRoom::furnished();
  Integrator integrator;
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection projection(floor.grid);
  for (int k = 0; k < 6; ++k) {
    const auto pose = camera_pose({-1.4, 0, 1.4}, -0.9 + 0.3 * k, 0.4);
    integrator.integrate(map, look(room, camera_of(170, 240, 0.6), pose, {.disparity_sigma = 0.15}, 0.15),
                         pose, at_seconds(k));
    projection.update(map, floor);
    const FloorMap whole = floor_map(map);
    EXPECT_EQ(floor.cells, whole.cells);
    EXPECT_EQ(floor.seen_at, whole.seen_at);
    EXPECT_LT(projection.columns_looked_into(), 196U) << "of 14 x 14";
    EXPECT_GT(projection.columns_looked_into(), 0U);
  }
}

TEST(FloorProjection, AllocatesNothingOnceItHasSeenAsMuch) {
  VoxelMap map(window());
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection projection(floor.grid);
  const auto change_all = [&](LogOdds value) {
    for (int x = 0; x < map.size().x(); x += 8)
      for (int y = 0; y < map.size().y(); y += 8) map.set({x, y, 15}, value, at_seconds(1));
  };
  change_all(70);
  projection.update(map, floor);
  change_all(-40);
  const std::uint64_t before = heap_allocations();
  projection.update(map, floor);
  EXPECT_EQ(heap_allocations(), before);
}

TEST(FloorProjection, RefusesAConfigurationThatMakesNoSense) {
  EXPECT_THROW(FloorProjection({0.1, {0, 0}, 4, 4}, {.floor_tolerance = -1}), InputError);
}

}  // namespace
}  // namespace headway::nav
