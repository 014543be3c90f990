#include "runtime/drift.h"

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <utility>

#include "hal/error.h"

namespace headway::runtime {
namespace {
// Of the covariance, when a view contradicts it. Views that follow one another show the same things and err
// alike: it takes a second of them to be believed.
constexpr double kWiden = 1.2;
constexpr double kStands = 1e-3;  // moves less than this [m, rad]
}  // namespace

void DriftConfig::validate() const {
  const auto check = [](const char* name, double value) {
    if (value >= 0 && value <= 1) return;
    throw InputError("localisation: " + std::string(name) + ": " + std::to_string(value) +
                     ", expected 0 to 1");
  };
  check("stride", stride);
  check("swerve", swerve);
  check("shift", shift);
  check("turn", turn);
  check("turn_of_turn", turn_of_turn);
}

Drift::Drift(const DriftConfig& config) : config_(config) {
  config.validate();
  covariance_(3, 3) = config.stride * config.stride;
  covariance_(4, 4) = config.swerve * config.swerve;
}

void Drift::doubt_start(double shift, double turn) {
  covariance_(0, 0) = covariance_(1, 1) = shift * shift;
  covariance_(2, 2) = turn * turn;
}

void Drift::move(const Pose2& odom_from_robot, Time stamp) {
  const double time = to_seconds(stamp - std::exchange(stamp_, stamp));
  if (!odom_from_robot_) {
    odom_from_robot_ = map_from_robot_ = odom_from_robot;
    return;
  }
  const Pose2 step = odom_from_robot_->inverse() * odom_from_robot;
  const double way = step.position().norm();
  if (way < kStands && std::abs(step.yaw) < kStands) return;
  odom_from_robot_ = odom_from_robot;
  const Pose2 before = map_from_robot_;
  map_from_robot_ = before * Pose2{step.x * (1 + stride_), step.y, step.yaw + swerve_ * time};

  const Eigen::Vector2d moved = map_from_robot_.position() - before.position();
  Matrix5 carried = Matrix5::Identity();
  carried(0, 2) = -moved.y();  // an error of yaw shifts what is walked after it
  carried(1, 2) = moved.x();
  carried.block<2, 1>(0, 3) = before.heading() * step.x;
  carried(2, 4) = time;
  covariance_ = carried * covariance_ * carried.transpose();
  const double shift = config_.shift * config_.shift * way;
  covariance_(0, 0) += shift;
  covariance_(1, 1) += shift;
  covariance_(2, 2) +=
      config_.turn * config_.turn * time + config_.turn_of_turn * config_.turn_of_turn * std::abs(step.yaw);
}

void Drift::correct(const nav::Alignment& alignment) {
  // Patches agree on a place that cannot be, so the doubt was too small.
  if (alignment.aligned == nav::Aligned::kTooFar) covariance_.topLeftCorner<3, 3>() *= kWiden;
  if (!alignment) return;
  // In a form that needs the inverse neither of the covariance nor of the information, for both may be zero
  // in some direction.
  Matrix5 information = Matrix5::Zero();
  information.topLeftCorner<3, 3>() = alignment.information;
  covariance_ = ((Matrix5::Identity() + covariance_ * information).inverse() * covariance_).eval();
  covariance_ = (covariance_ + covariance_.transpose()).eval() / 2;
  const Eigen::Matrix<double, 5, 1> change =
      covariance_.leftCols<3>() * (alignment.information * alignment.change);
  map_from_robot_.x += change[0];
  map_from_robot_.y += change[1];
  map_from_robot_.yaw = wrap_angle(map_from_robot_.yaw + change[2]);
  stride_ += change[3];
  swerve_ += change[4];
}

}  // namespace headway::runtime
