// The pose on the floor under a body in space.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "hal/pose2.h"

namespace headway {

/// Where a body's frame stands over the floor, and which way its x axis points.
inline Pose2 on_floor(const Eigen::Isometry3d& pose) {
  return {pose.translation().x(), pose.translation().y(),
          std::atan2(pose.linear()(1, 0), pose.linear()(0, 0))};
}

}  // namespace headway
