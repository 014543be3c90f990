#include "sim_hal/lens.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace headway::sim {

using Eigen::Matrix2d, Eigen::Vector2d, Eigen::Vector2f, Eigen::Vector3d;

Lens Lens::pinhole(int width, int height, double focal, double cx, double cy) {
  return {.width = width, .height = height, .fx = focal, .fy = focal, .cx = cx, .cy = cy};
}

Vector2d Lens::distorted(const Vector2d& n) const {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

Vector2d Lens::project(const Vector3d& point) const {
  const Vector2d d = distorted(point.head<2>() / point.z());
  return {fx * d.x() + cx, fy * d.y() + cy};
}

namespace {

Matrix2d jacobian(const Lens& l, const Vector2d& n) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (l.k1 + r2 * (l.k2 + r2 * l.k3));
  const double slope =
      2 * (l.k1 + r2 * (2 * l.k2 + r2 * 3 * l.k3));  // d radial / d(x or y), over that coordinate
  const double across = slope * x * y + 2 * (l.p1 * x + l.p2 * y);
  Matrix2d j;
  j << radial + slope * x * x + 2 * l.p1 * y + 6 * l.p2 * x, across, across,
      radial + slope * y * y + 6 * l.p1 * y + 2 * l.p2 * x;
  return j;
}

}  // namespace

Vector2d Lens::normalised(const Vector2d& pixel) const {
  const Vector2d target((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  Vector2d n = target;
  for (int i = 0; i < 30; ++i) {  // Newton
    const Vector2d error = distorted(n) - target;
    const Matrix2d j = jacobian(*this, n);
    // Beyond the fold of the distortion no ray leads to the pixel.
    if (!(j.determinant() > 0)) break;
    if (error.squaredNorm() < 1e-24) return n;
    n -= j.inverse() * error;
  }
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return {kNone, kNone};
}

std::vector<Vector2f> ray_table(const Lens& lens) {
  std::vector<Vector2f> rays;
  rays.reserve(static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height));
  for (int v = 0; v < lens.height; ++v)
    for (int u = 0; u < lens.width; ++u)
      rays.push_back(lens.normalised({static_cast<double>(u), static_cast<double>(v)}).cast<float>());
  return rays;
}

}  // namespace headway::sim
