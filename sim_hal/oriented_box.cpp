#include "sim_hal/oriented_box.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace headway::sim {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

// Points on the floor whose convex hull is the outline of what was cut out.
struct Outline {
  std::array<Vector2d, 32> points;  // at most 8 corners and 12 edges cut by two planes
  std::size_t count = 0;

  void add(const Vector3d& p) { points[count++] = p.head<2>(); }
};

using Corners = std::array<Vector3d, 8>;  // corner i: bit k of i tells the side along axis k

Corners corners_seen_from(const OrientedBox& box, const Solid& solid) {
  Corners corners;
  for (unsigned i = 0; i < 8; ++i) {
    const Vector3d sides((i & 1U) ? 0.5 : -0.5, (i & 2U) ? 0.5 : -0.5, (i & 4U) ? 0.5 : -0.5);
    corners[i] = solid.to_own(box.map_from_box * Vector3d(sides.cwiseProduct(box.size)));
  }
  return corners;
}

Outline cut_to_height(const Corners& corners, double half_height) {
  Outline outline;
  for (const Vector3d& c : corners)
    if (std::abs(c.z()) <= half_height) outline.add(c);
  for (unsigned i = 0; i < 8; ++i)
    for (unsigned bit = 1; bit < 8; bit <<= 1) {
      if (i & bit) continue;
      const Vector3d &a = corners[i], &b = corners[i | bit];
      for (const double plane : {-half_height, half_height})
        if ((a.z() < plane) != (b.z() < plane)) outline.add(a + (plane - a.z()) / (b.z() - a.z()) * (b - a));
    }
  return outline;
}

// Sorts the points into a convex polygon, counter-clockwise (Andrew's monotone chain).
void make_hull(Outline& outline) {
  auto& p = outline.points;
  std::sort(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(outline.count),
            [](const Vector2d& a, const Vector2d& b) {
              return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
            });
  std::array<Vector2d, 65> hull;
  std::size_t k = 0;
  const auto add = [&](const Vector2d& q, std::size_t least) {
    const auto turn = [&] {
      const Vector2d u = hull[k - 1] - hull[k - 2], v = q - hull[k - 2];
      return u.x() * v.y() - u.y() * v.x();
    };
    while (k >= least && turn() <= 0) --k;
    hull[k++] = q;
  };
  for (std::size_t i = 0; i < outline.count; ++i) add(p[i], 2);
  const std::size_t lower = k + 1;
  for (std::size_t i = outline.count - 1; i-- > 0;) add(p[i], lower);
  if (k > 1) --k;  // the first point again
  std::copy_n(hull.begin(), k, p.begin());
  outline.count = k;
}

// Does the open disc or rectangle about the origin meet the polygon?
bool meets(const Outline& hull, const Solid& solid) {
  const auto half_extent = [&](const Vector2d& normal) {
    return solid.shape == Shape::kCylinder
               ? solid.radius * normal.norm()
               : (std::abs(normal.x()) * solid.length + std::abs(normal.y()) * solid.width) / 2;
  };
  const auto separates = [&](const Vector2d& axis) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.count; ++i) least = std::min(least, axis.dot(hull.points[i]));
    return axis != Vector2d::Zero() && least >= half_extent(axis);
  };
  for (std::size_t i = 0; i < hull.count; ++i) {
    const Vector2d &a = hull.points[i], &b = hull.points[(i + 1) % hull.count];
    if (separates({a.y() - b.y(), b.x() - a.x()})) return false;
    if (solid.shape == Shape::kCylinder && separates(a)) return false;
  }
  if (solid.shape == Shape::kCylinder) return true;
  return !(separates(Vector2d::UnitX()) || separates(-Vector2d::UnitX()) || separates(Vector2d::UnitY()) ||
           separates(-Vector2d::UnitY()));
}

}  // namespace

bool overlap(const OrientedBox& box, const Solid& solid) noexcept {
  const double far = box.size.norm() / 2 + solid.reach();
  if ((box.map_from_box.translation().head<2>() - solid.pose.position()).squaredNorm() >= far * far)
    return false;
  Outline outline = cut_to_height(corners_seen_from(box, solid), (solid.top - solid.bottom) / 2);
  if (outline.count < 3) return false;
  make_hull(outline);
  return outline.count >= 3 && meets(outline, solid);
}

}  // namespace headway::sim
