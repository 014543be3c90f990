// The simulated robot and its cameras as a robot file describes them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "app/robot_file.h"
#include "runtime/eyes.h"
#include "sim_hal/robot.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_camera.h"
#include "sim_hal/sim_depth_camera.h"
#include "vision/rectify.h"

namespace headway::app {

/// What a run may change of the simulated robot.
struct SimulatedRobotOptions {
  /// Odometry that drifts by so much, beside what the robot file says: strides longer or shorter by this
  /// share, and each step turned too far, left or right, by this share of the widest turn. The seed draws
  /// which.
  double drift = 0;
  bool exact_feet = false;           ///< feet land where they should, and odometry without drift is the truth
  std::optional<double> tilt_error;  ///< of the head, instead of the robot file's [rad]
  std::uint64_t seed = 1;            ///< of all noise
  sim::FaultPlan faults;
};

sim::RobotConfig simulated_robot(const Robot& robot, const SimulatedRobotOptions& options);

/// The robot's rig as two cameras. Throws InputError for lenses that cannot be simulated.
sim::StereoCameraModel simulated_pair(const vision::StereoRig& rig, std::uint64_t seed);

/// The rig after rectification as one camera that measures depth, at the size of range mode.
sim::DepthCameraModel simulated_depth(const Robot& robot, const vision::RectifiedRig& rig,
                                      std::uint64_t seed);

/// Eyes that see with such a camera.
runtime::DepthEyes::Config depth_eyes(const sim::DepthCameraModel& model,
                                      const Eigen::Isometry3d& left_from_rectified);

/// What of the scene a part of the robot touches, if anything.
std::optional<std::string> touched(const sim::Scene& scene, const sim::BodyBox& box);

}  // namespace headway::app
