// How far odometry has drifted: where its frame lies in the map, and how sure that is.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "hal/pose2.h"
#include "hal/time.h"
#include "nav/localise.h"

namespace headway::runtime {

/// Standard deviations of what odometry errs.
struct DriftConfig {
  // Steadily, all the way: found out while walking.
  double stride = 0.03;   ///< share of the way ahead that is walked too far or too short
  double swerve = 0.004;  ///< turned too far to a side with each second of walking [rad/s]
  // At random, growing with the root of way and time:
  double shift = 0.01;         ///< within a metre of way [m]
  double turn = 0.003;         ///< within a second of walking [rad]
  double turn_of_turn = 0.02;  ///< within a radian of turning [rad]

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

/// An extended Kalman filter of the robot's planar pose and of what its odometry errs steadily. It begins
/// with map and odometry at one, and unless doubt_start() says otherwise they stay so until the robot moves.
class Drift {
 public:
  /// Throws InputError as DriftConfig::validate.
  explicit Drift(const DriftConfig& config = {});

  /// The robot is set up in a map that is known from before, to within these standard deviations [m, rad].
  void doubt_start(double shift, double turn);

  /// The robot's pose in the odometry frame at a later time than before. While it stands, nothing drifts.
  void move(const Pose2& odom_from_robot, Time stamp);
  /// The pose that move() was told of last is off by what an alignment about it found.
  void correct(const nav::Alignment& alignment);

  Pose2 map_from_odom() const {
    return odom_from_robot_ ? map_from_robot_ * odom_from_robot_->inverse() : Pose2{};
  }
  const Pose2& map_from_robot() const { return map_from_robot_; }
  /// Of the robot's x, y [m] and yaw [rad] in the map.
  Eigen::Matrix3d covariance() const { return covariance_.topLeftCorner<3, 3>(); }
  double stride() const { return stride_; }  ///< as in DriftConfig, as far as known
  double swerve() const { return swerve_; }

 private:
  using Matrix5 = Eigen::Matrix<double, 5, 5>;  ///< x, y, yaw, stride, swerve

  DriftConfig config_;
  std::optional<Pose2> odom_from_robot_;
  Time stamp_{};
  Pose2 map_from_robot_;
  double stride_ = 0, swerve_ = 0;
  Matrix5 covariance_ = Matrix5::Zero();
};

}  // namespace headway::runtime
