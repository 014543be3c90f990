// Where something low is to be stepped over.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "hal/pose2.h"
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

/// Whether some of the floor under a sole is low. Poses are those of the foot on the map.
bool is_on_low(const FloorMap& floor, const GaitLimits& gait, const Pose2& foot);
/// Whether some of it is low under a foot that swings from one place to another.
bool passes_low(const FloorMap& floor, const GaitLimits& gait, const Pose2& lift, const Pose2& landing);

}  // namespace headway::nav
