#include "vision/pixel_pairs.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "hal/error.h"
#include "vision/hull.h"

namespace headway::vision {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The right image's epipolar line of a left pixel: F (u, v, 1).
Matrix3d fundamental(const StereoRig& rig) {
  const Matrix3d left = left_projection(rig).leftCols<3>();
  Matrix3d right;
  right << rig.right.fx, 0, rig.right.cx, 0, rig.right.fy, rig.right.cy, 0, 0, 1;
  const Vector3d t = rig.right_from_left.translation();
  Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  return right.inverse().transpose() * cross * rig.right_from_left.linear() * left.inverse();
}

// Whole numbers from the first to the last, both among them.
std::vector<int> spread(double first, double last, int count) {
  std::vector<int> pixels;
  pixels.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    pixels.push_back(
        static_cast<int>(std::lround(std::lerp(first, last, static_cast<double>(i) / (count - 1)))));
  return pixels;
}

Vector2d through_pinhole(const CameraIntrinsics& c, const Vector3d& ray) {
  return {c.fx * ray.x() / ray.z() + c.cx, c.fy * ray.y() / ray.z() + c.cy};
}

// Where an ideal lens in place of the camera's shows what a pixel shows. Nothing beyond 84 deg from the axis.
std::optional<Vector2d> ideal_pixel(const CameraIntrinsics& c, const Vector2d& raw) {
  if (!c.distorts()) return raw;
  const auto ray = c.unproject(raw);
  if (!ray || ray->z() < 0.1) return std::nullopt;
  return through_pinhole(c, *ray);
}

// The whole pixel that shows what an ideal lens shows there. Nothing outside the image.
std::optional<Vector2d> raw_pixel(const CameraIntrinsics& c, const Vector2d& ideal) {
  const Vector2d at =
      c.distorts() ? c.project({(ideal.x() - c.cx) / c.fx, (ideal.y() - c.cy) / c.fy, 1}) : ideal;
  const Vector2d pixel(std::round(at.x()), std::round(at.y()));
  if (pixel.x() >= 0 && pixel.x() < c.width && pixel.y() >= 0 && pixel.y() < c.height) return pixel;
  return std::nullopt;
}

// The first and last column of an ideal lens that the image shows, in the middle of its height or at its rim.
std::pair<double, double> ideal_columns(const CameraIntrinsics& c) {
  double first = 0, last = c.width - 1;
  if (!c.distorts()) return {first, last};
  for (const double v : {0.0, (c.height - 1) / 2.0, c.height - 1.0}) {
    if (const auto p = ideal_pixel(c, {0, v})) first = std::min(first, p->x());
    if (const auto p = ideal_pixel(c, {c.width - 1.0, v})) last = std::max(last, p->x());
  }
  return {first, last};
}

// All pairs of pixels that the images have in common: as an ideal lens would show what they show.
template <class Use>
void for_each_pair(const StereoRig& rig, const PixelPairConfig& config, const Use& use) {
  const Matrix3d f = fundamental(rig);
  const auto [first, last] = ideal_columns(rig.right);
  const std::vector<int> columns = spread(0, rig.left.width - 1, config.columns),
                         right_columns = spread(first, last, config.right_columns);
  for (const int v : spread(0, rig.left.height - 1, config.rows))
    for (const int u : columns) {
      const auto in_left = ideal_pixel(rig.left, Vector2d(u, v));
      if (!in_left) continue;
      const Vector3d line = f * in_left->homogeneous();
      if (line.y() == 0) continue;
      for (const int u_right : right_columns) {
        const Vector2d on_line(u_right, -(line.x() * u_right + line.z()) / line.y());
        const auto raw = raw_pixel(rig.right, on_line);
        if (!raw) continue;
        if (const auto in_right = ideal_pixel(rig.right, *raw)) use(*in_left, *in_right);
      }
    }
}

}  // namespace

PixelPairField pixel_pair_field(const StereoRig& rig, const FieldLimits& limits,
                                const PixelPairConfig& config) {
  require_usable(rig);
  if (std::min({config.columns, config.rows, config.right_columns}) < 2)
    throw InputError("pixel pairs: expected at least 2 columns and rows");
  const auto left = left_projection(rig), right = right_projection(rig);
  const Vector3d axis = depth_axis(rig);
  PixelPairField field;
  std::vector<Vector3d> positions;
  Vector3d middle = Vector3d::Zero();
  for_each_pair(rig, config, [&](const Vector2d& in_left, const Vector2d& in_right) {
    ++field.pairs;
    const auto point = triangulate(left, right, in_left, in_right, config.pixel_sigma);
    if (!point) return;
    const double z = axis.dot(point->position);
    if (z < limits.near || z > limits.far) return;
    field.points.push_back(*point);
    positions.push_back(point->position);
    middle += point->position;
  });
  field.hull = hull_polytope(positions);
  field.minimal = minimal_polytope(merged(field.hull.rows, config.merge_angle, config.merge_offset),
                                   middle / static_cast<double>(positions.size()));
  return field;
}

}  // namespace headway::vision
