// A path as straight legs.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "nav/planner.h"

namespace headway::nav {

/// A stretch of the path: the robot faces `yaw` and goes to `to`.
struct Leg {
  Eigen::Vector2d from, to;
  double yaw = 0, direction = 0;  ///< [rad]
  bool sideway = false;
};

/// From path.start to path.end, in between from cell centre to cell centre. None for a path that stays.
std::vector<Leg> legs_of(const Path& path, const FloorGrid& grid);

}  // namespace headway::nav
