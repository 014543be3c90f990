#include "nav/walking/support_polygon.h"

#include <algorithm>
#include <limits>
#include <span>

namespace headway::nav {
namespace {

using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

void add_corners(const Pose2& foot, double length, double width, std::span<Vector2d> into) {
  const double x = length / 2, y = width / 2;
  into[0] = foot * Vector2d(x, -y);
  into[1] = foot * Vector2d(x, y);
  into[2] = foot * Vector2d(-x, y);
  into[3] = foot * Vector2d(-x, -y);
}

}  // namespace

SupportPolygon::SupportPolygon(const Pose2& foot, double length, double width) : size_(4) {
  add_corners(foot, length, width, corners_);
}

/// Andrew's monotone chain.
SupportPolygon::SupportPolygon(const Pose2& left, const Pose2& right, double length, double width) {
  std::array<Vector2d, 8> points;
  add_corners(left, length, width, std::span(points).first(4));
  add_corners(right, length, width, std::span(points).last(4));
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::array<Vector2d, 17> hull;
  std::size_t n = 0;
  const auto add = [&](const Vector2d& p, std::size_t keep) {
    while (n >= keep + 2 && cross(hull[n - 1] - hull[n - 2], p - hull[n - 2]) <= 0) --n;
    hull[n++] = p;
  };
  for (std::size_t i = 0; i < points.size(); ++i) add(points[i], 0);
  const std::size_t lower = n - 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  size_ = n - 1;
  std::copy_n(hull.begin(), size_, corners_.begin());
}

double SupportPolygon::margin(const Vector2d& point) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < size_; ++i) {
    const Vector2d edge = corners_[(i + 1) % size_] - corners_[i];
    smallest = std::min(smallest, cross(edge, point - corners_[i]) / edge.norm());
  }
  return smallest;
}

}  // namespace headway::nav
