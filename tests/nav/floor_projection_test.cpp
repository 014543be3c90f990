// What the floor is, is read from a tree of OctoMap's own, column by column.
#include "nav/floor_projection.h"

#include <algorithm>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <rapidcheck/gtest.h>

#include "attic.h"
#include "hal/error.h"
#include "nav/integrate.h"
#include "synthetic_room.h"
#include "tests/heap_count.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d, Eigen::Vector2i, Eigen::Vector3d;
using Index = VoxelMap::Index;

VoxelMapConfig window() {
  VoxelMapConfig config;
  config.resolution = 0.1;
  config.lowest = {-1.6, -1.6, -0.8};
  config.highest = {1.6, 2.4, 1.6};
  return config;
}

constexpr int kUnseenValue = -128;

/// A change of one voxel.
struct Change {
  Vector3d centre;
  int value;
  bool sees_floor;
};

/// Voxels near the middle, so that neighbours meet.
std::vector<Change> change_some(VoxelMap& map, int most, Time stamp) {
  std::vector<Change> changes(static_cast<std::size_t>(*rc::gen::inRange(0, most)));
  for (Change& change : changes) {
    const Index i(*rc::gen::inRange(0, map.size().x()), *rc::gen::inRange(10, 22),
                  *rc::gen::inRange(0, map.size().z()));
    change = {map.centre(i), *rc::gen::element(kUnseenValue, -40, 5, 20, 70), *rc::gen::arbitrary<bool>()};
    map.set(i, static_cast<LogOdds>(change.value), stamp);
    if (change.sees_floor) map.see_floor(i.x(), i.y(), stamp);
  }
  return changes;
}

/// A column of the floor, as its number along x and y.
using ColumnKey = std::pair<long, long>;
ColumnKey column_key(double x, double y) { return {std::lround(10 * x - 0.5), std::lround(10 * y - 0.5)}; }

/// The same voxels in a tree of OctoMap's, and the rule of the floor as the documentation has it.
class TreeFloor {
 public:
  void take(const std::vector<Change>& changes, Time stamp) {
    for (const auto& [p, value, sees_floor] : changes) {
      const octomap::OcTreeKey key = octomap::OcTree(kResolution).coordToKey(p.x(), p.y(), p.z());
      voxels_.erase(key);
      if (value != kUnseenValue) voxels_.emplace(key, 0.05F * static_cast<float>(value));
      if (sees_floor) seen_[column_key(p.x(), p.y())] = stamp;
    }
  }
  Time seen(const ColumnKey& key) const {
    const auto found = seen_.find(key);
    return found == seen_.end() ? kNever : found->second;
  }

  /// What else than voxels says of a column.
  void look_closely_within(const ColumnKey& first, const ColumnKey& last) {
    near_first_ = first;
    near_last_ = last;
  }
  void rises(const ColumnKey& key, FloorProjection::Rise rise) { rises_[key] = rise; }

  void expect(const FloorMap& floor, const FloorMapConfig& config) const {
    const std::map<ColumnKey, Column> columns = look_into(config);
    for (int y = 0; y < floor.grid.height; ++y) {
      for (int x = 0; x < floor.grid.width; ++x) {
        const Vector2d centre = floor.grid.centre({x, y});
        RC_ASSERT(floor.at({x, y}) == decide(columns, column_key(centre.x(), centre.y()), config));
      }
    }
  }

 private:
  struct Column {
    int obstacles = 0;
    bool strong = false, floor = false;
    bool tall = false, surely_tall = false;  // higher than what may be stepped over
  };

  std::map<ColumnKey, Column> look_into(const FloorMapConfig& config) const {
    octomap::OcTree tree(kResolution);
    constexpr bool kLazy = true;  // leaves stay single voxels
    for (const auto& [key, value] : voxels_) tree.setNodeValue(key, value, kLazy);
    std::map<ColumnKey, Column> columns;
    for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
      RC_ASSERT(leaf.getDepth() == tree.getTreeDepth());
      if (!tree.isNodeOccupied(*leaf)) continue;
      Column& column = columns[column_key(leaf.getX(), leaf.getY())];
      column.floor |= std::abs(leaf.getZ()) < 0.1;
      if (leaf.getZ() < config.floor_tolerance || leaf.getZ() > config.body_height) continue;
      ++column.obstacles;
      const bool strong = leaf->getLogOdds() > 0.05F * (static_cast<float>(config.strong) - 0.5F);
      const bool tall = leaf.getZ() > config.step_over + 1.5 * kResolution;
      column.strong |= strong;
      column.tall |= tall;
      column.surely_tall |= tall && strong;
    }
    return columns;
  }
  FloorProjection::Rise rise(const ColumnKey& key) const {
    const auto found = rises_.find(key);
    return found == rises_.end() ? FloorProjection::Rise::kUnknown : found->second;
  }
  Floor decide(const std::map<ColumnKey, Column>& columns, const ColumnKey& key,
               const FloorMapConfig& config) const {
    using Rise = FloorProjection::Rise;
    const auto found = columns.find(key);
    const Column own = found == columns.end() ? Column{} : found->second;
    int around = 0;
    bool low_around = false;
    for (long dy = -1; dy <= 1; ++dy) {
      for (long dx = -1; dx <= 1; ++dx) {
        const auto near = columns.find({key.first + dx, key.second + dy});
        if (near != columns.end()) around += near->second.obstacles;
        low_around |= rise({key.first + dx, key.second + dy}) == Rise::kLow;
      }
    }
    const bool rises = rise(key) == Rise::kLow || rise(key) == Rise::kHigh;
    bool rises_near = false;
    for (long dy = -2; dy <= 2; ++dy)
      for (long dx = -2; dx <= 2; ++dx) rises_near |= rise({key.first + dx, key.second + dy}) >= Rise::kLow;
    const bool smear = config.step_over > 0 && rise(key) == Rise::kLevel && !own.tall && rises_near;
    const bool stands = !smear && (own.strong || (own.obstacles > 0 && around >= config.voxels_to_block));
    if (!rises && !stands) return own.floor ? Floor::kFree : Floor::kUnseen;
    const auto within = [](long low, long at, long high) { return low <= at && at <= high; };
    const bool is_near = within(near_first_.first, key.first, near_last_.first) &&
                         within(near_first_.second, key.second, near_last_.second);
    const bool low = config.step_over > 0 && rise(key) != Rise::kHigh && !own.surely_tall &&
                     (low_around || (!own.tall && !is_near));
    return low ? Floor::kLow : Floor::kBlocked;
  }

  static constexpr double kResolution = 0.1;
  std::unordered_map<octomap::OcTreeKey, float, octomap::OcTreeKey::KeyHash> voxels_;
  std::map<ColumnKey, Time> seen_;
  std::map<ColumnKey, FloorProjection::Rise> rises_;
  ColumnKey near_first_{1, 1}, near_last_{0, 0};
};

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

RC_GTEST_PROP(FloorProjection, IsWhatTheColumnsOfATreeSayAfterAnyChanges, ()) {
  VoxelMap map(window());
  TreeFloor tree;
  FloorMapConfig config;
  config.voxels_to_block = *rc::gen::inRange(1, 4);
  config.floor_tolerance = *rc::gen::element(0.08, 0.2, 0.4);
  config.body_height = *rc::gen::element(0.7, 1.2, 1.7);
  config.strong = static_cast<LogOdds>(*rc::gen::element(20, 34, 71));
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection projection(floor.grid, config);
  for (int update = 0; update < 6; ++update) {
    tree.take(change_some(map, 60, at_seconds(update)), at_seconds(update));
    projection.update(map, floor);
    tree.expect(floor, config);
    for (int y = 0; y < floor.grid.height; ++y) {
      for (int x = 0; x < floor.grid.width; ++x) {
        const Vector2d centre = floor.grid.centre({x, y});
        RC_ASSERT(floor.seen({x, y}) == tree.seen(column_key(centre.x(), centre.y())));
      }
    }
  }
}

/// Where changes are, so that both meet.
void let_some_rise(const FloorGrid& grid, FloorProjection& projection, TreeFloor& tree) {
  using Rise = FloorProjection::Rise;
  for (int left = *rc::gen::inRange(0, 60); left > 0; --left) {
    const Vector2i cell(*rc::gen::inRange(0, grid.width), *rc::gen::inRange(9, 23));
    const Rise rise = *rc::gen::element(Rise::kUnknown, Rise::kLevel, Rise::kLow, Rise::kHigh);
    projection.set_rise(cell, rise);
    tree.rises(column_key(grid.centre(cell).x(), grid.centre(cell).y()), rise);
  }
}

RC_GTEST_PROP(FloorProjection, TellsWhatMayBeSteppedOverFromWhatBlocks, ()) {
  VoxelMap map(window());
  TreeFloor tree;
  FloorMapConfig config;
  config.floor_tolerance = *rc::gen::element(0.08, 0.2);
  config.step_over = *rc::gen::element(0.0, 0.06, 0.14);
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection projection(floor.grid, config);
  for (int update = 0; update < 6; ++update) {
    tree.take(change_some(map, 60, at_seconds(update)), at_seconds(update));
    let_some_rise(floor.grid, projection, tree);
    const Vector2i from(*rc::gen::inRange(0, floor.grid.width), *rc::gen::inRange(0, floor.grid.height)),
        to = from + Vector2i(*rc::gen::inRange(0, 12), *rc::gen::inRange(0, 12));
    const Vector2d first = floor.grid.centre(from), last = floor.grid.centre(to);
    projection.look_closely_within({from, to});
    tree.look_closely_within(column_key(first.x(), first.y()), column_key(last.x(), last.y()));
    projection.update(map, floor);
    tree.expect(floor, config);
    if (config.step_over == 0)
      RC_ASSERT(std::find(floor.cells.begin(), floor.cells.end(), Floor::kLow) == floor.cells.end());
  }
}

TEST(FloorProjection, ShowsALowBarAsLowAndItsSmearAsFloor) {
  using Rise = FloorProjection::Rise;
  VoxelMap map(window());
  for (const double step_over : {0.0, 0.06}) {
    FloorMapConfig config;
    config.step_over = step_over;
    FloorMap floor = unseen_floor(floor_grid(map));
    FloorProjection projection(floor.grid, config);
    const int foot = map.foot_begin();
    for (const int y : {3, 4, 5}) map.set({3, y, foot}, 70, at_seconds(1));
    for (const int y : {3, 4, 5}) map.set({3, y, 9}, 70, at_seconds(1));  // 0.15 m
    map.set({3, 5, 12}, 70, at_seconds(1));                               // 0.45 m
    projection.set_rise({3, 3}, Rise::kLow);
    projection.set_rise({3, 4}, Rise::kLevel);
    projection.set_rise({3, 5}, Rise::kLow);
    projection.update(map, floor);
    const bool over = step_over > 0;
    EXPECT_EQ(floor.at({3, 3}), over ? Floor::kLow : Floor::kBlocked);
    EXPECT_EQ(floor.at({3, 4}), over ? Floor::kFree : Floor::kBlocked);
    EXPECT_EQ(floor.at({3, 5}), Floor::kBlocked) << "a sure voxel stands higher";
    for (const int y : {3, 5}) projection.set_rise({3, y}, Rise::kLevel);
    projection.update(map, floor);
    EXPECT_EQ(floor.at({3, 4}), over ? Floor::kLow : Floor::kBlocked) << "it is nothing's smear";
  }
}

RC_GTEST_PROP(FloorProjection, FollowsTheWindowOverALargerFloor, ()) {
  VoxelMap map(window());
  Attic attic;
  FloorMap floor = unseen_floor({0.1, {-8, -8}, 160, 160});
  FloorProjection projection(floor.grid);
  TreeFloor tree;  // needs no window
  for (int move = 0; move < 5; ++move) {
    tree.take(change_some(map, 60, at_seconds(move)), at_seconds(move));
    projection.update(map, floor);
    tree.expect(floor, {});
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
