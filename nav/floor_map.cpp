#include "nav/floor_map.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "hal/error.h"

namespace headway::nav {
namespace {

/// What stands in the columns, gathered from the bricks.
struct Columns {
  std::vector<std::uint8_t> obstacles;  ///< occupied voxels between floor tolerance and body height
  std::vector<std::uint8_t> strong;     ///< one of them is sure
  std::vector<std::uint8_t> floor;      ///< an occupied voxel at the foot
};

constexpr int kAtOnce = 8;  ///< values of a brick that lie in one layer and are looked at together

/// Whether one of eight voxels is occupied: all others are negative.
bool any_occupied(const LogOdds* values) {
  static_assert(log_odds::kOccupied == 0);
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, values, sizeof bytes);
  return (~bytes & 0x8080808080808080U) != 0;
}

void gather(const VoxelMap& map, const FloorMapConfig& config, std::size_t brick, const FloorGrid& grid,
            Columns& columns) {
  const VoxelMap::Index first = kBrickEdge * map.brick_at(brick);
  const auto values = map.values(brick);
  for (int i = 0; i < kBrickVoxels; i += kAtOnce) {
    const LogOdds* some = values.data() + i;
    if (!any_occupied(some)) continue;
    const int z = first.z() + voxel_of_brick(i).z;
    const double height = map.centre({0, 0, z}).z();
    const bool foot = z >= map.foot_begin() && z < map.foot_end();
    const bool obstacle = height > config.floor_tolerance && height < config.body_height;
    if (!foot && !obstacle) continue;
    for (int k = 0; k < kAtOnce; ++k) {
      if (some[k] < log_odds::kOccupied) continue;
      const VoxelOfBrick in = voxel_of_brick(i + k);
      const std::size_t cell = grid.index({first.x() + in.x, first.y() + in.y});
      if (foot) columns.floor[cell] = 1;
      if (!obstacle) continue;
      columns.obstacles[cell] = static_cast<std::uint8_t>(std::min(columns.obstacles[cell] + 1, 28));
      if (some[k] >= config.strong) columns.strong[cell] = 1;
    }
  }
}

/// Occupied voxels in the columns of a cell and its neighbours.
int obstacles_around(const Columns& columns, const FloorGrid& grid, int x, int y) {
  int sum = 0;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, grid.height - 1); ++j) {
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, grid.width - 1); ++i) {
      sum += columns.obstacles[grid.index({i, j})];
    }
  }
  return sum;
}

}  // namespace

FloorMap unseen_floor(const FloorGrid& grid) {
  return {grid, std::vector<Floor>(grid.size(), Floor::kUnseen), std::vector<Time>(grid.size(), kNever)};
}

void FloorMapConfig::validate() const {
  const auto refuse = [](const std::string& what) { throw InputError("floor map: " + what); };
  if (!(floor_tolerance >= 0 && floor_tolerance <= 0.5)) {
    refuse("floor_tolerance: " + std::to_string(floor_tolerance) + " m, expected 0 to 0.5 m");
  }
  if (!(body_height > floor_tolerance && body_height <= 10)) {
    refuse("body_height: " + std::to_string(body_height) +
           " m, expected more than floor_tolerance, at most 10 m");
  }
  if (voxels_to_block < 1 || voxels_to_block > 9) {
    refuse("voxels_to_block: " + std::to_string(voxels_to_block) + ", expected 1 to 9");
  }
}

FloorGrid floor_grid(const VoxelMap& map) {
  return {map.resolution(), map.lowest().head<2>(), map.size().x(), map.size().y()};
}

FloorGrid floor_grid(const VoxelMapConfig& box) {
  const BrickRange bricks = bricks_in(box);
  const Eigen::Vector2i size = kBrickEdge * (bricks.end - bricks.first).head<2>();
  return {box.resolution, (kBrickEdge * bricks.first.head<2>()).cast<double>() * box.resolution, size.x(),
          size.y()};
}

void copy_floor(const FloorMap& part, FloorMap& whole) {
  const Eigen::Vector2i offset =
      ((part.grid.origin - whole.grid.origin) / whole.grid.resolution).array().round().cast<int>();
  const Eigen::Array2i size(part.grid.width, part.grid.height),
      whole_size(whole.grid.width, whole.grid.height);
  const Eigen::Array2i end = offset.array() + size;
  const Eigen::Array2i first = (offset.array() > 0).select(offset.array() + 1, 0),
                       last = (end < whole_size).select(end - 2, whole_size - 1);
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      const std::size_t from = part.grid.index({x - offset.x(), y - offset.y()}),
                        to = whole.grid.index({x, y});
      whole.cells[to] = part.cells[from];
      whole.seen_at[to] = std::max(whole.seen_at[to], part.seen_at[from]);
    }
  }
}

void floor_map(const VoxelMap& map, const FloorMapConfig& config, FloorMap& into) {
  config.validate();
  into.grid = floor_grid(map);
  const std::size_t n = into.grid.size();
  Columns columns{std::vector<std::uint8_t>(n), std::vector<std::uint8_t>(n), std::vector<std::uint8_t>(n)};
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    if (map.summary(b).occupied > 0) gather(map, config, b, into.grid, columns);
  }
  into.cells.resize(n);
  into.seen_at.resize(n);
  for (int y = 0; y < into.grid.height; ++y) {
    for (int x = 0; x < into.grid.width; ++x) {
      const std::size_t cell = into.grid.index({x, y});
      const bool blocked =
          columns.strong[cell] || (columns.obstacles[cell] > 0 &&
                                   obstacles_around(columns, into.grid, x, y) >= config.voxels_to_block);
      into.cells[cell] = blocked ? Floor::kBlocked : columns.floor[cell] ? Floor::kFree : Floor::kUnseen;
      into.seen_at[cell] = map.floor_seen_at(x, y);
    }
  }
}

FloorMap floor_map(const VoxelMap& map, const FloorMapConfig& config) {
  FloorMap floor;
  floor_map(map, config, floor);
  return floor;
}

void start_clear(FloorMap& floor, const Pose2& start, const StartArea& area, Time stamp,
                 bool robot_is_there) {
  const Pose2 start_from_map = start.inverse();
  const double reach = std::max(area.radius, area.footprint_half.norm());
  const Eigen::Vector2i first = floor.grid.cell(start.position() - Eigen::Vector2d::Constant(reach));
  const Eigen::Vector2i last = floor.grid.cell(start.position() + Eigen::Vector2d::Constant(reach));
  for (int y = std::max(first.y(), 0); y <= std::min(last.y(), floor.grid.height - 1); ++y) {
    for (int x = std::max(first.x(), 0); x <= std::min(last.x(), floor.grid.width - 1); ++x) {
      const Eigen::Vector2d seen_from_start = start_from_map * floor.grid.centre({x, y});
      const bool under_robot =
          robot_is_there && (seen_from_start.array().abs() <= area.footprint_half.array()).all();
      const std::size_t cell = floor.grid.index({x, y});
      if (!under_robot && (seen_from_start.norm() > area.radius || floor.cells[cell] != Floor::kUnseen))
        continue;
      floor.cells[cell] = Floor::kFree;
      floor.seen_at[cell] = std::max(floor.seen_at[cell], stamp);
    }
  }
}

}  // namespace headway::nav
