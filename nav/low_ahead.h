// Where on a straight way something low is to be stepped over.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "nav/floor_map.h"
#include "nav/walking/gait.h"

namespace headway::nav {

/// Between these places along the way no sole's middle may be put down [m].
struct LowStretch {
  double begin, end;
};

/// The low ground that the soles of both feet would meet on a way through `point` in direction `yaw`, by
/// rising distance along it (the dot product with its direction, from the map's origin on), from `first` to
/// `last`. Stretches between which no sole has room are one.
std::vector<LowStretch> low_ahead(const FloorMap& floor, const Eigen::Vector2d& point, double yaw,
                                  double first, double last, const GaitLimits& gait);

bool any_low(const FloorMap& floor);

}  // namespace headway::nav
