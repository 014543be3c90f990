#include "nav/floor_projection.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace headway::nav {
namespace {

using Eigen::AlignedBox2i;
using Eigen::Vector2i;

constexpr int kAtOnce = 8;          // values of a brick that lie in one layer and are looked at together
constexpr double kSmear = 1.5;      // voxels that what is low fills above itself; points tell better
constexpr int kMostObstacles = 28;  // nine times as many still fit into a byte

/// Whether one of eight voxels is occupied: all others are negative.
bool any_occupied(const LogOdds* values) {
  static_assert(log_odds::kOccupied == 0);
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, values, sizeof bytes);
  return (~bytes & 0x8080808080808080U) != 0;
}

/// Cell (0, 0) of a grid among the voxel columns of space.
Vector2i first_column(const FloorGrid& grid) {
  return (grid.origin / grid.resolution).array().round().cast<int>();
}

}  // namespace

FloorProjection::FloorProjection(const FloorGrid& grid, const FloorMapConfig& config)
    : grid_(grid), config_(config), columns_(grid.size()), rises_(grid.size(), Rise::kUnknown) {
  config.validate();
}

void FloorProjection::update(const VoxelMap& map, FloorMap& floor) {
  const Vector2i window = map.first_key().head<2>() - first_column(grid_);
  changed_.clear();
  for (int y = 0; y < map.bricks().y(); ++y) {
    for (int x = 0; x < map.bricks().x(); ++x) {
      if (map.column_changed(x, y) <= changes_) continue;
      changed_.emplace_back(window + kBrickEdge * Vector2i(x, y));
      gather(map, {x, y}, changed_.back(), floor);
    }
  }
  changes_ = map.changes();
  for (const Vector2i& first : changed_)
    decide({first - Vector2i::Ones(), first + Vector2i::Constant(kBrickEdge)}, floor);
  if (!again_.isEmpty()) decide(again_, floor);
  again_.setEmpty();
}

void FloorProjection::gather(const VoxelMap& map, const Vector2i& bricks, const Vector2i& first,
                             FloorMap& floor) {
  for (int y = 0; y < kBrickEdge; ++y) {
    for (int x = 0; x < kBrickEdge; ++x) {
      const Vector2i cell = first + Vector2i(x, y);
      if (!grid_.contains(cell)) continue;
      columns_[grid_.index(cell)] = {};
      Time& seen = floor.seen_at[grid_.index(cell)];
      seen = std::max(seen, map.floor_seen_at(kBrickEdge * bricks.x() + x, kBrickEdge * bricks.y() + y));
    }
  }
  for (int z = 0; z < map.bricks().z(); ++z) {
    const std::size_t brick = map.brick_index({bricks.x(), bricks.y(), z});
    if (map.summary(brick).occupied > 0) gather_brick(map, brick, kBrickEdge * z, first);
  }
}

void FloorProjection::gather_brick(const VoxelMap& map, std::size_t brick, int first_z,
                                   const Vector2i& first) {
  const auto values = map.values(brick);
  for (int i = 0; i < kBrickVoxels; i += kAtOnce) {
    const LogOdds* some = values.data() + i;
    if (!any_occupied(some)) continue;
    const int z = first_z + voxel_of_brick(i).z;
    const double height = map.centre({0, 0, z}).z();
    const bool foot = z >= map.foot_begin() && z < map.foot_end();
    const bool obstacle = height > config_.floor_tolerance && height < config_.body_height;
    if (!foot && !obstacle) continue;
    const bool tall = height > config_.step_over + kSmear * map.resolution();
    for (int k = 0; k < kAtOnce; ++k) {
      const VoxelOfBrick in = voxel_of_brick(i + k);
      const Vector2i cell = first + Vector2i(in.x, in.y);
      if (some[k] < log_odds::kOccupied || !grid_.contains(cell)) continue;
      Column& column = columns_[grid_.index(cell)];
      column.floor |= foot;
      if (!obstacle) continue;
      column.obstacles = static_cast<std::uint8_t>(std::min(column.obstacles + 1, kMostObstacles));
      column.strong |= some[k] >= config_.strong;
      column.tall |= tall;
      column.surely_tall |= tall && some[k] >= config_.strong;
    }
  }
}

void FloorProjection::decide(const AlignedBox2i& cells, FloorMap& floor) const {
  const Vector2i low = cells.min().cwiseMax(0),
                 high = cells.max().cwiseMin(Vector2i(grid_.width - 1, grid_.height - 1));
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      const std::size_t cell = grid_.index({x, y});
      const Column& column = columns_[cell];
      floor.cells[cell] = is_occupied({x, y}) ? (is_low({x, y}) ? Floor::kLow : Floor::kBlocked)
                          : column.floor      ? Floor::kFree
                                              : Floor::kUnseen;
    }
  }
}

bool FloorProjection::is_occupied(const Vector2i& cell) const {
  const std::size_t i = grid_.index(cell);
  const Column& column = columns_[i];
  if (rises_[i] >= Rise::kLow) return true;
  const bool smear = config_.step_over > 0 && rises_[i] == Rise::kLevel && !column.tall;
  if (smear && any_around(cell, kSmearReach, [](Rise r) { return r >= Rise::kLow; })) return false;
  return column.strong || (column.obstacles > 0 && obstacles_around(cell) >= config_.voxels_to_block);
}

/// Of an occupied cell.
bool FloorProjection::is_low(const Vector2i& cell) const {
  const std::size_t i = grid_.index(cell);
  if (config_.step_over <= 0 || columns_[i].surely_tall || rises_[i] == Rise::kHigh) return false;
  return any_around(cell, 1, [](Rise r) { return r == Rise::kLow; }) ||
         (!columns_[i].tall && !near_.contains(cell));
}

/// Whether `is` holds for what a cell no farther off than so many cells does.
template <class Is>
bool FloorProjection::any_around(const Vector2i& cell, int reach, const Is& is) const {
  const Vector2i around = Vector2i::Constant(reach);
  const Vector2i low = (cell - around).cwiseMax(0),
                 high = (cell + around).cwiseMin(Vector2i(grid_.width - 1, grid_.height - 1));
  for (int y = low.y(); y <= high.y(); ++y)
    for (int x = low.x(); x <= high.x(); ++x)
      if (is(rises_[grid_.index({x, y})])) return true;
  return false;
}

/// Occupied voxels in the columns of a cell and its neighbours.
int FloorProjection::obstacles_around(const Vector2i& cell) const {
  const Vector2i low = (cell - Vector2i::Ones()).cwiseMax(0),
                 high = (cell + Vector2i::Ones()).cwiseMin(Vector2i(grid_.width - 1, grid_.height - 1));
  int sum = 0;
  for (int y = low.y(); y <= high.y(); ++y)
    for (int x = low.x(); x <= high.x(); ++x) sum += columns_[grid_.index({x, y})].obstacles;
  return sum;
}

}  // namespace headway::nav
