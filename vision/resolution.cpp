#include "vision/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/error.h"

namespace headway::vision {

namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

struct Ray {
  Vector3d from, along;  // along has z = 1, so that its length is counted in depth
};

// Where the ray runs inside the polytope: depths beyond its start. Empty when last < first.
struct Interval {
  double first = 0, last = 0;
};

Interval inside(const Polytope& field, const Ray& ray) {
  Interval in{0, std::numeric_limits<double>::infinity()};
  for (const Vector4d& row : field.rows) {
    const double at_start = row.dot(ray.from.homogeneous()), slope = row.head<3>().dot(ray.along);
    if (std::abs(slope) < 1e-12) {
      if (at_start < -1e-9) return {1, 0};
    } else if (slope > 0) {
      in.first = std::max(in.first, -at_start / slope);
    } else {
      in.last = std::min(in.last, -at_start / slope);
    }
  }
  return in;
}

// The rays of pixels from edge to edge of both images.
std::vector<Ray> lattice(const RectifiedRig& rig) {
  constexpr int kColumns = 16, kRows = 16;
  const PinholeCamera& c = rig.camera;
  PinholeCamera right = c;
  right.cx += rig.disparity_offset;
  std::vector<Ray> rays;
  for (int j = 0; j <= kRows; ++j)
    for (int i = 0; i <= kColumns; ++i) {
      const double u = -0.5 + c.width * (static_cast<double>(i) / kColumns);
      const double v = -0.5 + c.height * (static_cast<double>(j) / kRows);
      rays.push_back({Vector3d::Zero(), c.point(u, v, 1)});
      rays.push_back({Vector3d(rig.baseline, 0, 0), right.point(u, v, 1)});
    }
  return rays;
}

// How far along the ray, up to `in.last`, points are seen so well. Resolution grows along every ray.
double last_resolved(const RectifiedRig& rig, const Ray& ray, const Interval& in, double finest) {
  const auto resolved = [&](double z) { return resolution(rig, ray.from + z * ray.along) <= finest; };
  if (resolved(in.last)) return in.last;
  double yes = in.first, no = in.last;
  for (int i = 0; i < 40; ++i) {
    const double middle = (yes + no) / 2;
    (resolved(middle) ? yes : no) = middle;
  }
  return yes;
}

}  // namespace

double resolution(const RectifiedRig& rig, const Vector3d& point) {
  const double lateral = point.z() / rig.camera.focal * RangeView::kPixelSigma;
  const double relative = rig.disparity_sigma * point.z() / (rig.camera.focal * rig.baseline);
  // In the plane of the axis and the point, with p = relative * (rho, Z):
  //   [[lateral^2 + p_rho^2, p_rho p_Z], [p_rho p_Z, p_Z^2]]; across it only lateral^2.
  const double rho = relative * std::hypot(point.x(), point.y()), z = relative * point.z();
  const double a = lateral * lateral + rho * rho, b = rho * z, d = z * z;
  return std::sqrt((a + d) / 2 + std::hypot((a - d) / 2, b));
}

std::vector<Vector3d> resolved_points(const RectifiedRig& rig, const Polytope& field, double finest) {
  std::vector<Vector3d> points;
  for (const Ray& ray : lattice(rig)) {
    const Interval in = inside(field, ray);
    if (!(in.last >= in.first) || resolution(rig, ray.from + in.first * ray.along) > finest) continue;
    points.emplace_back(ray.from + in.first * ray.along);
    points.emplace_back(ray.from + last_resolved(rig, ray, in, finest) * ray.along);
  }
  return points;
}

std::optional<Polytope> resolution_polytope(const RectifiedRig& rig, const Polytope& field, double finest) {
  const std::vector<Vector3d> points = resolved_points(rig, field, finest);
  // Of a few points that just reach the nearest plane no volume is left.
  try {
    return hull_polytope(points);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace headway::vision
