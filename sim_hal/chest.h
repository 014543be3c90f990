// Where the chest is while the robot walks: over the centre of mass, swaying a little with its acceleration.
#pragma once

#include <Eigen/Geometry>

namespace headway::sim {

struct ChestConfig {
  double height = 1.0;                    ///< of the chest frame above the floor [m]
  double ahead_of_com = 0.0;              ///< of the chest frame's origin, along the heading [m]
  double roll_per_acceleration = 0.004;   ///< [rad per m/s^2]: leans against sideways acceleration
  double pitch_per_acceleration = 0.004;  ///< [rad per m/s^2]: leans back when accelerating forward

  void validate() const;
};

/// frame_from_chest for a CoM at `com` [m] with `acceleration` [m/s^2], all in the same frame; `yaw` [rad].
Eigen::Isometry3d chest_pose(const ChestConfig& config, const Eigen::Vector2d& com,
                             const Eigen::Vector2d& acceleration, double yaw);

}  // namespace headway::sim
