#include "nav/body_outline.h"

#include <algorithm>
#include <limits>
#include <string>

#include "hal/error.h"

namespace headway::nav {

namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

/// Distance from a point to the rectangle |x| <= half.x, |y| <= half.y.
double distance_to_box(const Vector2d& point, const Vector2d& half) {
  return (point.cwiseAbs() - half).cwiseMax(0.0).norm();
}

void expect(bool good, const std::string& key, double value, const std::string& expected) {
  if (!good) throw InputError("body: " + key + ": is " + std::to_string(value) + ", expected " + expected);
}

/// Cells of the grid nearer than `clearance` to a rectangle (half sides `half`) at `pose`.
std::vector<Vector2i> cells_near(const FloorGrid& grid, const BodyOutline& outline, const Pose2& pose) {
  const double reach = outline.reach();
  const Vector2i low = grid.cell(pose.position() - Vector2d(reach, reach)).cwiseMax(0);
  const Vector2i high =
      grid.cell(pose.position() + Vector2d(reach, reach)).cwiseMin(Vector2i(grid.width - 1, grid.height - 1));
  std::vector<Vector2i> cells;
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      if (distance_to_square(outline, pose, grid.centre({x, y}), grid.resolution) <= outline.clearance()) {
        cells.emplace_back(x, y);
      }
    }
  }
  return cells;
}

}  // namespace

void BodyOutline::validate() const {
  const auto length = [](double v, const char* key) { expect(v >= 0 && v <= 1, key, v, "0 to 1 m"); };
  length(half_depth, "half_depth");
  length(half_width, "half_width");
  length(sway, "sway");
  length(safety_margin, "safety_margin");
}

double distance_to_square(const BodyOutline& outline, const Pose2& base, const Vector2d& centre,
                          double size) {
  const double c = std::cos(base.yaw), s = std::sin(base.yaw);
  const Vector2d offset = centre - base.position();
  const Vector2d in_base(c * offset.x() + s * offset.y(), -s * offset.x() + c * offset.y());
  const Vector2d rectangle(outline.half_depth, outline.half_width);
  const double half = size / 2;
  const double span = half * (std::abs(c) + std::abs(s));
  const Vector2d shadow(std::abs(c) * rectangle.x() + std::abs(s) * rectangle.y(),
                        std::abs(s) * rectangle.x() + std::abs(c) * rectangle.y());
  const bool apart = (offset.cwiseAbs().array() > shadow.array() + half).any() ||
                     (in_base.cwiseAbs().array() > rectangle.array() + span).any();
  if (!apart) return 0;  // no side of either parts them, so they meet
  // Else the nearest points are a corner of the one and a side of the other.
  double nearest = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 4; ++corner) {
    const double sx = (corner & 1) ? 1 : -1, sy = (corner & 2) ? 1 : -1;
    const Vector2d of_square(in_base.x() + half * (c * sx + s * sy), in_base.y() + half * (-s * sx + c * sy));
    nearest = std::min(nearest, distance_to_box(of_square, rectangle));
    const double rx = sx * rectangle.x(), ry = sy * rectangle.y();
    const Vector2d of_rectangle(c * rx - s * ry - offset.x(), s * rx + c * ry - offset.y());
    nearest = std::min(nearest, distance_to_box(of_rectangle, {half, half}));
  }
  return nearest;
}

std::vector<Vector2i> body_cells(const FloorGrid& grid, const BodyOutline& outline, const Pose2& base) {
  return cells_near(grid, outline, base);
}

std::vector<Vector2i> sole_cells(const FloorGrid& grid, const GaitLimits& gait, const Pose2& foot) {
  return cells_near(grid, {gait.sole_length / 2, gait.sole_width / 2, 0, 0}, foot);
}

}  // namespace headway::nav
