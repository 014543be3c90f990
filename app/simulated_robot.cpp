#include "app/simulated_robot.h"

#include <algorithm>
#include <cmath>

#include "hal/error.h"

namespace headway::app {

namespace {

/// The control computer knows the gait of its robot: it takes the steps that the robot file asks for. What
/// the body makes of them is another matter.
void allow(const nav::GaitLimits& gait, sim::ControlComputerConfig& control) {
  constexpr double kWire = 0.004;  // what a step may gain by rounding [m, rad]
  sim::StrideLimits& limits = control.limits;
  limits.forward = std::max(limits.forward, gait.forward + kWire);
  limits.backward = std::max(limits.backward, gait.backward + kWire);
  limits.nearest_side = std::min(limits.nearest_side, gait.feet_apart - gait.inward - kWire);
  limits.farthest_side = std::max(limits.farthest_side, gait.feet_apart + gait.outward + kWire);
  limits.yaw = std::max(limits.yaw, gait.yaw + kWire);
  limits.clear = std::max(limits.clear, hal::quantised({{}, {}, 0, {}, gait.over.height}).clear);
  limits.forward_over = std::max(limits.forward_over, gait.over.forward + kWire);
  control.walking = nav::walking_config(gait);
  control.gait = gait;
}

/// The seed's two lowest bits draw whether strides are longer or shorter, and to which side steps turn.
void drift(const nav::GaitLimits& gait, double share, std::uint64_t seed, sim::BodyConfig& body) {
  const bool longer = seed % 2 == 1, left = seed / 2 % 2 == 1;
  body.stride_scale *= longer ? 1 + share : 1 - share;
  body.yaw_per_step += (left ? share : -share) * gait.yaw;
}

/// Legs that reach as far as such steps go. Below the ankles there is nothing of the robot but its feet.
void let_step_over(const nav::GaitLimits& gait, sim::RobotConfig& config) {
  constexpr double kLandsOff = 0.02;  // [m]
  config.body.reach = std::max(config.body.reach, std::hypot(gait.over.forward, gait.feet_apart) + kLandsOff);
  config.shape.legs_low = config.shape.foot_high;
}

sim::Lens lens(const vision::CameraIntrinsics& c) {
  if (c.lens != vision::LensModel::kRadialTangential)
    throw InputError(
        "rig: the simulated cameras have radial-tangential lenses, expected a rig with such ones");
  return {c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3};
}

}  // namespace

sim::RobotConfig simulated_robot(const Robot& robot, const SimulatedRobotOptions& options) {
  sim::RobotConfig config;
  config.kinematics = robot.mission.neck;
  config.kinematics.zero.tilt += options.tilt_error.value_or(robot.simulation.tilt_error);
  config.feet_apart = robot.mission.gait.feet_apart;
  config.frame_rate = robot.simulation.frame_rate;
  config.body = robot.simulation.body;
  config.body.seed = config.fault_seed = options.seed;
  config.faults = options.faults;
  if (options.exact_feet) config.body.landing_sigma = config.body.landing_yaw_sigma = 0;
  drift(robot.mission.gait, options.drift, options.seed, config.body);
  config.body.chest.height = robot.chest_height;
  config.control.chest.height = robot.chest_height;
  allow(robot.mission.gait, config.control);
  if (robot.mission.gait.over.height > 0) let_step_over(robot.mission.gait, config);
  return config;
}

sim::StereoCameraModel simulated_pair(const vision::StereoRig& rig, std::uint64_t seed) {
  sim::StereoCameraModel model;
  model.left = lens(rig.left);
  model.right = lens(rig.right);
  model.right_from_left = rig.right_from_left;
  model.seed = seed;
  return model;
}

/// The rig after rectification, at the size of range mode.
sim::DepthCameraModel simulated_depth(const Robot& robot, const vision::RectifiedRig& rig,
                                      std::uint64_t seed) {
  const double scale = static_cast<double>(robot.simulation.depth_image.x()) / rig.camera.width;
  sim::DepthCameraModel model;
  model.width = robot.simulation.depth_image.x();
  model.height = robot.simulation.depth_image.y();
  model.focal = rig.camera.focal * scale;
  model.cx = (rig.camera.cx + 0.5) * scale - 0.5;
  model.cy = (rig.camera.cy + 0.5) * scale - 0.5;
  model.baseline = rig.baseline;
  model.nearest = rig.nearest;
  model.farthest = rig.farthest;
  model.disparity_sigma = rig.disparity_sigma * scale;  // the same error of depth as at the full size
  model.seed = seed;
  return model;
}

runtime::DepthEyes::Config depth_eyes(const sim::DepthCameraModel& m,
                                      const Eigen::Isometry3d& left_from_rectified) {
  runtime::DepthEyes::Config config;
  config.camera = {m.width, m.height, m.focal, m.cx, m.cy};
  config.near = m.nearest;
  config.far = m.farthest;
  config.sigma = vision::StereoDepthSigma{m.focal * m.baseline, m.disparity_sigma};
  config.left_from_view = left_from_rectified;
  return config;
}

std::optional<std::string> touched(const sim::Scene& scene, const sim::BodyBox& box) {
  const Eigen::Vector3d x = box.map_from_box.linear().col(0);
  const sim::Solid part = sim::Solid::box(box.map_from_box.translation(), box.size, std::atan2(x.y(), x.x()));
  const auto contact = scene.collides(std::span(&part, 1), Pose2{});
  if (!contact) return std::nullopt;
  return scene.name_of(static_cast<int>(contact->solid));
}

}  // namespace headway::app
