#include "vision/pixel_pairs.h"

#include <algorithm>
#include <cmath>

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

// Whole pixels from the first to the last, both among them.
std::vector<int> spread(int size, int count) {
  std::vector<int> pixels;
  for (int i = 0; i < count; ++i)
    pixels.push_back(static_cast<int>(std::lround((size - 1) * (static_cast<double>(i) / (count - 1)))));
  return pixels;
}

// All pairs that the images have in common, to whole pixels.
template <class Use>
void for_each_pair(const StereoRig& rig, const PixelPairConfig& config, const Use& use) {
  const Matrix3d f = fundamental(rig);
  const std::vector<int> columns = spread(rig.left.width, config.columns),
                         right_columns = spread(rig.right.width, config.right_columns);
  for (const int v : spread(rig.left.height, config.rows))
    for (const int u : columns) {
      const Vector3d line = f * Vector3d(u, v, 1);
      if (line.y() == 0) continue;
      for (const int u_right : right_columns) {
        const double v_right = std::round(-(line.x() * u_right + line.z()) / line.y());
        if (v_right >= 0 && v_right < rig.right.height) use(Vector2d(u, v), Vector2d(u_right, v_right));
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
