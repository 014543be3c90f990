// The floor seen from above: where the robot may put its body, where it may not, and what it has not seen.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/pose2.h"
#include "hal/time.h"
#include "nav/voxel_map.h"

namespace headway::nav {

enum class Floor : std::uint8_t {
  kUnseen = 0,
  kFree = 1,
  kBlocked = 2,
  kLow = 3,  ///< something stands there that a foot may step over, but not onto
};
/// Whether no foot may be put down there.
constexpr bool is_occupied(Floor f) { return f == Floor::kBlocked || f == Floor::kLow; }

/// A raster on the floor. Cell (0, 0) has the lowest x and y.
struct FloorGrid {
  double resolution = 0.05;      ///< edge of a cell [m]
  Eigen::Vector2d origin{0, 0};  ///< lower-left corner of cell (0, 0) in the map frame [m]
  int width = 0, height = 0;     ///< cells along x and y

  bool contains(const Eigen::Vector2i& cell) const {
    return cell.x() >= 0 && cell.y() >= 0 && cell.x() < width && cell.y() < height;
  }
  /// The cell that holds a point of the map frame [m]; may lie outside.
  Eigen::Vector2i cell(const Eigen::Vector2d& point) const {
    return {static_cast<int>(std::floor((point.x() - origin.x()) / resolution)),
            static_cast<int>(std::floor((point.y() - origin.y()) / resolution))};
  }
  /// The middle of a cell in the map frame [m].
  Eigen::Vector2d centre(const Eigen::Vector2i& cell) const {
    return {origin.x() + (cell.x() + 0.5) * resolution, origin.y() + (cell.y() + 0.5) * resolution};
  }
  /// Row-major, row 0 = lowest y. Only for cells of the grid.
  std::size_t index(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(cell.x());
  }
  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }

  friend bool operator==(const FloorGrid&, const FloorGrid&) = default;
};

struct FloorMap {
  FloorGrid grid;
  std::vector<Floor> cells;  ///< FloorGrid::index
  std::vector<Time>
      seen_at;  ///< when the floor there, or what stands on it, was last observed; kNever before

  /// kUnseen outside the grid.
  Floor at(const Eigen::Vector2i& cell) const {
    return grid.contains(cell) ? cells[grid.index(cell)] : Floor::kUnseen;
  }
  /// kNever outside the grid.
  Time seen(const Eigen::Vector2i& cell) const {
    return grid.contains(cell) ? seen_at[grid.index(cell)] : kNever;
  }
};

/// A map in which nothing has been seen.
FloorMap unseen_floor(const FloorGrid& grid);

struct FloorMapConfig {
  double floor_tolerance = 0.08;  ///< occupied voxels with centres up to this height [m] are floor
  double body_height = 1.70;      ///< what begins above this [m] is no obstacle
  /// A cell is blocked when so many occupied voxels stand in its column, at least one, and the eight around
  /// it ...
  int voxels_to_block = 2;
  /// ... or when one voxel of its own column is at least this sure (two hits). A lone weak voxel is a
  /// speckle.
  LogOdds strong = 34;
  /// What is known to rise no higher than this [m] is low; 0: nothing is, it blocks.
  double step_over = 0;

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

/// The grid of a voxel map: its columns.
FloorGrid floor_grid(const VoxelMap& map);
/// The same of a map with this box.
FloorGrid floor_grid(const VoxelMapConfig& box);

/// Projects the map on the floor. Blocked: occupied voxels between floor tolerance and body height; low where
/// FloorMapConfig::step_over allows. Free: neither, and the floor itself (an occupied voxel at the column's
/// foot) has been seen, so a hole is never free. Unseen: else. FloorProjection does the same from what has
/// changed.
FloorMap floor_map(const VoxelMap& map, const FloorMapConfig& config = {});

/// The area around the start that the operator vouches for.
struct StartArea {
  double radius = 0.8;                         ///< [m] unseen floor this near the start counts as free
  Eigen::Vector2d footprint_half{0.15, 0.20};  ///< half length and width [m] of where the robot itself stands
};

/// The cells of the grid that start_clear may change.
Eigen::AlignedBox2i start_cells(const FloorGrid& grid, const Pose2& start, const StartArea& area);
/// Counts the start area as free and seen at `stamp` or later, as far as the start leads to it
/// without crossing what is blocked: not behind a wall. What is blocked stays so, except under the robot's
/// own footprint while it stands there: nothing else can.
void start_clear(FloorMap& floor, const Pose2& start, const StartArea& area, Time stamp,
                 bool robot_is_there = true);

}  // namespace headway::nav
