#include "sim_hal/solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace headway::sim {

using Eigen::Vector2d, Eigen::Vector3d;

Solid Solid::box(const Vector3d& centre, const Vector3d& size, double yaw) {
  Solid s;
  s.shape = Shape::kBox;
  s.pose = {centre.x(), centre.y(), wrap_angle(yaw)};
  s.bottom = centre.z() - size.z() / 2;
  s.top = centre.z() + size.z() / 2;
  s.length = size.x();
  s.width = size.y();
  return s;
}

Solid Solid::cylinder(const Vector3d& base, double radius, double height) {
  Solid s;
  s.shape = Shape::kCylinder;
  s.pose = {base.x(), base.y(), 0};
  s.bottom = base.z();
  s.top = base.z() + height;
  s.radius = radius;
  return s;
}

double Solid::reach() const { return shape == Shape::kBox ? std::hypot(length, width) / 2 : radius; }

Solid Solid::moved(const Pose2& parent) const {
  Solid s = *this;
  s.pose = parent * pose;
  return s;
}

Vector3d Solid::to_own(const Vector3d& point) const {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const double x = point.x() - pose.x, y = point.y() - pose.y;
  return {c * x + s * y, c * y - s * x, point.z() - centre_height()};
}

Vector3d Solid::from_own(const Vector3d& point) const {
  const Vector2d p = pose * Vector2d(point.head<2>());
  return {p.x(), p.y(), point.z() + centre_height()};
}

bool Solid::contains(const Vector3d& point) const {
  const Vector3d p = to_own(point);
  if (std::abs(p.z()) > (top - bottom) / 2) return false;
  if (shape == Shape::kCylinder) return p.head<2>().squaredNorm() <= radius * radius;
  return std::abs(p.x()) <= length / 2 && std::abs(p.y()) <= width / 2;
}

namespace {

double distance_to_rectangle(const Vector2d& own_point, double length, double width) {
  const double x = std::max(std::abs(own_point.x()) - length / 2, 0.0);
  const double y = std::max(std::abs(own_point.y()) - width / 2, 0.0);
  return std::hypot(x, y);
}

std::array<Vector2d, 4> corners(const Solid& box) {
  const double x = box.length / 2, y = box.width / 2;
  return {box.pose * Vector2d(x, y), box.pose * Vector2d(-x, y), box.pose * Vector2d(-x, -y),
          box.pose * Vector2d(x, -y)};
}

// Gap between two boxes along the axes of the first: positive when one of its sides separates them.
double gap_along_axes(const Solid& a, const Solid& b) {
  const Pose2 a_from_b = a.pose.inverse() * b.pose;
  const double c = std::abs(std::cos(a_from_b.yaw)), s = std::abs(std::sin(a_from_b.yaw));
  const double x = std::abs(a_from_b.x) - (a.length + c * b.length + s * b.width) / 2;
  const double y = std::abs(a_from_b.y) - (a.width + s * b.length + c * b.width) / 2;
  return std::max(x, y);
}

double corner_distance(const Solid& from, const Solid& to) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector2d& corner : corners(from))
    least = std::min(least, distance_to_rectangle(to.pose.inverse() * corner, to.length, to.width));
  return least;
}

}  // namespace

double floor_distance(const Solid& a, const Solid& b) {
  if (a.shape == Shape::kCylinder && b.shape == Shape::kCylinder)
    return std::max((a.pose.position() - b.pose.position()).norm() - a.radius - b.radius, 0.0);
  if (a.shape == Shape::kCylinder) return floor_distance(b, a);
  if (b.shape == Shape::kCylinder)
    return std::max(distance_to_rectangle(a.pose.inverse() * b.pose.position(), a.length, a.width) - b.radius,
                    0.0);
  // Separating axes: for rectangles the four sides' normals decide whether they overlap.
  if (gap_along_axes(a, b) < 0 && gap_along_axes(b, a) < 0) return 0;
  return std::min(corner_distance(a, b), corner_distance(b, a));
}

bool overlap(const Solid& a, const Solid& b) {
  if (a.top <= b.bottom || b.top <= a.bottom) return false;
  const double far = a.reach() + b.reach();
  if ((a.pose.position() - b.pose.position()).squaredNorm() >= far * far) return false;
  if (a.shape == Shape::kBox && b.shape == Shape::kBox)
    return gap_along_axes(a, b) < 0 && gap_along_axes(b, a) < 0;
  return floor_distance(a, b) == 0;
}

}  // namespace headway::sim
