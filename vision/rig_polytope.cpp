#include "vision/rig_polytope.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::vision {

namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using Projection = Eigen::Matrix<double, 3, 4>;
using Rows = std::vector<Vector4d>;

// The four sides of an image's pyramid. With P = pixel from point and w = P_3 x the depth, u >= u0 is
// (P_1 - u0 P_3) x >= 0 for all points before the camera; the four together say w >= 0.
void add_pyramid(const Projection& p, int width, int height, int blind_columns, Rows& rows) {
  const double u0 = blind_columns - 0.5, u1 = width - 0.5, v0 = -0.5, v1 = height - 0.5;
  rows.push_back(half_space(p.row(0) - u0 * p.row(2)));
  rows.push_back(half_space(u1 * p.row(2) - p.row(0)));
  rows.push_back(half_space(p.row(1) - v0 * p.row(2)));
  rows.push_back(half_space(v1 * p.row(2) - p.row(1)));
}

void add_depths(const Vector3d& axis, const FieldLimits& limits, Rows& rows) {
  if (limits.near > 0) rows.emplace_back(axis.x(), axis.y(), axis.z(), -limits.near);
  if (std::isfinite(limits.far)) rows.emplace_back(-axis.x(), -axis.y(), -axis.z(), limits.far);
}

void require_sensible(const FieldLimits& limits, int width) {
  if (!(limits.near >= 0 && limits.far > limits.near))
    throw InputError(
        fmt::format("field: depths from {} to {} m, expected 0 <= near < far", limits.near, limits.far));
  if (limits.blind_columns < 0 || limits.blind_columns >= width)
    throw InputError(
        fmt::format("field: {} blind columns, expected 0 to {}", limits.blind_columns, width - 1));
}

// The depths that the pyramids have in common tell whether the images or the limits leave nothing.
Polytope limited(const std::string& rig, const Rows& pyramids, const Vector3d& axis,
                 const FieldLimits& limits) {
  const auto endless = minimal_polytope(pyramids);
  if (!endless) throw InputError(rig + ": no point lies in both images; the cameras look past each other");
  Rows rows = pyramids;
  add_depths(axis, limits, rows);
  if (auto field = minimal_polytope(rows)) return *std::move(field);
  double first = std::numeric_limits<double>::infinity(), last = 0;
  for (const Vector3d& corner : endless->corners) {
    first = std::min(first, axis.dot(corner));
    last = std::max(last, axis.dot(corner));
  }
  const std::string to = endless->directions.empty() ? fmt::format(" and ends at {:.3g} m", last) : "";
  throw InputError(fmt::format(
      "{}: no point from {:g} to {:g} m lies in both images; their common view begins at {:.3g} m{}", rig,
      limits.near, limits.far, first, to));
}

Projection projection(const CameraIntrinsics& c, const Eigen::Isometry3d& camera_from_left) {
  Eigen::Matrix3d k;
  k << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1;
  return k * camera_from_left.matrix().topRows<3>();
}

}  // namespace

FieldLimits depth_limits(const RectifiedRig& rig, const DisparityRange& range) {
  const double least = range.lowest + rig.disparity_offset;
  FieldLimits limits;
  limits.near = rig.depth(range.lowest + range.count - 1);
  if (least > 0) limits.far = rig.depth(range.lowest);
  return limits;
}

Polytope rig_polytope(const RectifiedRig& rig, const FieldLimits& limits) {
  const PinholeCamera& c = rig.camera;
  if (!(rig.baseline > 0) || !(c.focal > 0))
    throw InputError(
        fmt::format("rectified rig: baseline {} m and focal length {} px, expected more than 0: two "
                    "cameras at one place tell no depth",
                    rig.baseline, c.focal));
  require_sensible(limits, c.width);
  const double f = c.focal;
  Projection left, right;
  left << f, 0, c.cx, 0, 0, f, c.cy, 0, 0, 0, 1, 0;
  right << f, 0, c.cx + rig.disparity_offset, -f * rig.baseline, 0, f, c.cy, 0, 0, 0, 1, 0;
  Rows rows;
  add_pyramid(left, c.width, c.height, limits.blind_columns, rows);
  add_pyramid(right, c.width, c.height, 0, rows);
  return limited("rectified rig", rows, Vector3d::UnitZ(), limits);
}

Polytope rig_polytope(const StereoRig& rig, const FieldLimits& limits) {
  require_usable(rig);
  require_sensible(limits, rig.left.width);
  Rows rows;
  add_pyramid(left_projection(rig), rig.left.width, rig.left.height, limits.blind_columns, rows);
  add_pyramid(right_projection(rig), rig.right.width, rig.right.height, 0, rows);
  return limited("rig " + rig.name, rows, depth_axis(rig), limits);
}

Vector3d depth_axis(const StereoRig& rig) {
  const Eigen::Isometry3d left_from_right = rig.right_from_left.inverse();
  const Vector3d along = left_from_right.translation().normalized();
  const Vector3d mean = Vector3d::UnitZ() + left_from_right.linear().col(2);
  return (mean - along * along.dot(mean)).normalized();
}

Projection left_projection(const StereoRig& rig) {
  return projection(rig.left, Eigen::Isometry3d::Identity());
}
Projection right_projection(const StereoRig& rig) { return projection(rig.right, rig.right_from_left); }

}  // namespace headway::vision
