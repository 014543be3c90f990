// A floor without end with boxes on it, seen through an ideal camera: what fake eyes look at.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "runtime/mapper.h"

namespace headway::runtime {

/// Upright, along the axes, on the floor [m].
using Box = Eigen::AlignedBox3d;
using Boxes = std::vector<Box>;

inline Box box(double x_low, double x_high, double y_low, double y_high, double height) {
  return {Eigen::Vector3d(x_low, y_low, 0), Eigen::Vector3d(x_high, y_high, height)};
}

/// Distance along a ray, in lengths of `direction`, to the floor or a box.
inline double cast(const Boxes& boxes, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double nearest = direction.z() < 0 ? -origin.z() / direction.z() : std::numeric_limits<double>::infinity();
  for (const Box& b : boxes) {
    const Eigen::Array3d one = (b.min() - origin).array() / direction.array(),
                         two = (b.max() - origin).array() / direction.array();
    const double in = one.min(two).maxCoeff(), out = one.max(two).minCoeff();
    if (in > 0 && in <= out) nearest = std::min(nearest, in);
  }
  return nearest;
}

/// What a camera of 200 x 150 pixels sees; nothing at all when `covered`.
inline vision::RangeView look(const Boxes& boxes, const Eigen::Isometry3d& map_from_camera,
                              bool covered = false) {
  vision::RangeView view;
  view.camera = {200, 150, 120, 99.5, 74.5};
  view.near = 0.3;
  view.far = 8;
  const std::size_t pixels = 200 * 150;
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  view.depth.assign(pixels, nothing);
  view.sigma_depth.assign(pixels, nothing);
  for (int v = 0; v < 150 && !covered; ++v)
    for (int u = 0; u < 200; ++u) {
      const Eigen::Vector3d ray = map_from_camera.linear() * view.camera.point(u, v, 1);
      const double z = cast(boxes, map_from_camera.translation(), ray);
      if (z < view.near || z > view.far) continue;
      view.depth[view.index(u, v)] = static_cast<float>(z);
      view.sigma_depth[view.index(u, v)] = 0.002F;
    }
  return view;
}

/// From `height` metres above a place, straight down, the image's up along +y.
inline Eigen::Isometry3d from_above(const Eigen::Vector2d& place, double height) {
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  map_from_camera.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  map_from_camera.translation() << place, height;
  return map_from_camera;
}

/// 7 m by 5 m, the robot at its origin.
inline MapperConfig small_map() {
  MapperConfig config;
  config.voxels.lowest = {-1.6, -2.4, -0.4};
  config.voxels.highest = {5.2, 2.4, 2.4};
  return config;
}

}  // namespace headway::runtime
