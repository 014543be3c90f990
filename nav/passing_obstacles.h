// Obstacles that came where the floor was free before, and when anything was last seen standing on a cell:
// what came may have gone again.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "nav/floor_map.h"
#include "vision/range_view.h"

namespace headway::nav {

class PassingObstacles {
 public:
  PassingObstacles(const FloorGrid& grid, const FloorMapConfig& heights);

  /// Takes in a look: where points of it are obstacles, something stands.
  void look(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera, Time stamp);
  /// Takes in the floor (on the same grid) as it is now known.
  void see(const FloorMap& floor);
  /// Something was seen standing on a cell (of the grid) that is too low for look().
  void stands(const Eigen::Vector2i& cell, Time stamp) {
    Time& stood = stood_at_[grid_.index(cell)];
    stood = std::max(stood, stamp);
  }

  /// Whether a cell (FloorGrid::index) was free at any time.
  bool was_free(std::size_t cell) const { return was_free_[cell] != 0; }
  /// Whether the floor was free at any time under a point of the map frame and in all cells around: what is
  /// there now moves.
  bool amid_free(const Eigen::Vector2d& point) const;
  /// When something was last seen standing on a cell (FloorGrid::index); kNever before.
  Time stood_at(std::size_t cell) const { return stood_at_[cell]; }

 private:
  FloorGrid grid_;
  FloorMapConfig heights_;
  std::vector<std::uint8_t> was_free_, points_;  ///< points: of the look in hand
  std::vector<Time> stood_at_;
  std::vector<std::size_t> counted_;
};

}  // namespace headway::nav
