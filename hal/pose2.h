// A pose on the floor: x forward, y left, yaw counter-clockwise.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace headway {

/// The same angle in [-pi, pi).
inline double wrap_angle(double a) {
  constexpr double kTurn = 2 * std::numbers::pi;
  a = std::fmod(a + std::numbers::pi, kTurn);
  return (a < 0 ? a + kTurn : a) - std::numbers::pi;
}

/// Position in metres, yaw in radians. As a transform it maps points of the pose's own frame to its parent.
struct Pose2 {
  double x = 0, y = 0, yaw = 0;

  Eigen::Vector2d position() const { return {x, y}; }
  Eigen::Vector2d heading() const { return {std::cos(yaw), std::sin(yaw)}; }

  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {x + c * p.x() - s * p.y(), y + s * p.x() + c * p.y()};
  }
  /// parent_from_b = parent_from_a * a_from_b
  Pose2 operator*(const Pose2& b) const {
    const Eigen::Vector2d p = *this * b.position();
    return {p.x(), p.y(), wrap_angle(yaw + b.yaw)};
  }
  Pose2 inverse() const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {-c * x - s * y, s * x - c * y, wrap_angle(-yaw)};
  }
  Eigen::Isometry3d lifted(double z = 0) const {
    Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
    t.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    t.translation() << x, y, z;
    return t;
  }
};

/// From `a` (share 0) straight to `b` (share 1), the yaw the short way.
inline Pose2 interpolate(const Pose2& a, const Pose2& b, double share) {
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
          wrap_angle(a.yaw + share * wrap_angle(b.yaw - a.yaw))};
}

}  // namespace headway
