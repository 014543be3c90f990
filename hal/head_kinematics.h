// Where the cameras are, given the neck's angles.
#pragma once

#include <Eigen/Geometry>

#include "hal/head.h"

namespace headway::hal {

/// Fixed transforms of chest -> pan joint -> tilt joint -> left camera. Chest, pan and tilt frames are x
/// forward, y left, z up at zero angles; the camera frame is optical (z forward, x right, y down).
struct HeadKinematics {
  Eigen::Isometry3d chest_from_pan = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d pan_from_tilt = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d tilt_from_camera = Eigen::Isometry3d::Identity();
  HeadAngles zero{};  ///< the joints' true angles less those that the drives report [rad]

  /// At angles as the drives report them.
  Eigen::Isometry3d chest_from_camera(const HeadAngles& a) const {
    using Eigen::AngleAxisd, Eigen::Vector3d;
    return chest_from_pan * AngleAxisd(a.pan + zero.pan, Vector3d::UnitZ()) * pan_from_tilt *
           AngleAxisd(a.tilt + zero.tilt, Vector3d::UnitY()) * tilt_from_camera;
  }

  /// Angles (not limited) that point the camera's optical axis at a point in the chest frame [m].
  HeadAngles look_at(const Eigen::Vector3d& point_in_chest) const;
};

/// Rotation from the optical frame (z forward, y down) to x forward, y left, z up, then tilted down by `down`
/// [rad].
Eigen::Matrix3d body_from_optical(double down = 0);

}  // namespace headway::hal
