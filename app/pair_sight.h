// What both cameras of a pair see, by the truth: what only one of them sees has no depth.
#pragma once

#include <Eigen/Geometry>

#include "sim_hal/scene.h"
#include "vision/range_view.h"

namespace headway::app {

struct PairSight {
  vision::PinholeCamera camera;      ///< the left one, rectified; the right one's is the same
  double baseline = 0;               ///< from the left to the right one, along x [m]
  double nearest = 0, farthest = 0;  ///< depths that they measure [m]

  /// Whether both have a point of the left one's optical frame in their images, within their depths.
  bool in_view(const Eigen::Vector3d& p) const;
  /// Whether nothing hides a point of the map from either of them.
  bool in_sight(const sim::Scene& scene, const Eigen::Isometry3d& map_from_view,
                const Eigen::Vector3d& point) const;
};

}  // namespace headway::app
