// How a real lens maps directions to pixels: pinhole with radial and tangential distortion (plumb bob,
// "radtan").
#pragma once

#include <Eigen/Core>
#include <vector>

namespace headway::sim {

struct Lens {
  int width = 0, height = 0;              ///< [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]; pixel centres lie at whole numbers
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  /// A camera without distortion.
  static Lens pinhole(int width, int height, double focal, double cx, double cy);

  /// Normalised coordinates (X/Z, Y/Z) to distorted ones.
  Eigen::Vector2d distorted(const Eigen::Vector2d& normalised) const;
  /// Pixel at which a point of the optical frame is seen.
  Eigen::Vector2d project(const Eigen::Vector3d& point) const;
  /// (X/Z, Y/Z) of the ray through a pixel; NaN where the distortion cannot be undone.
  Eigen::Vector2d normalised(const Eigen::Vector2d& pixel) const;
};

/// (X/Z, Y/Z) for each pixel, row-major.
std::vector<Eigen::Vector2f> ray_table(const Lens& lens);

}  // namespace headway::sim
