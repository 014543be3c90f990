// Images whose truth is known: a texture that is defined everywhere, not only at pixels, and planes that
// carry it.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "hal/frame.h"
#include "vision/rig.h"

namespace headway::vision::test {

/// Noise in 0..1 at a lattice point; the same for the same seed everywhere.
inline double lattice(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  std::uint64_t h = seed * 0x9E3779B97F4A7C15ULL + static_cast<std::uint64_t>(x) * 0xBF58476D1CE4E5B9ULL +
                    static_cast<std::uint64_t>(y) * 0x94D049BB133111EBULL;
  h ^= h >> 31, h *= 0xD6E8FEB86659FD93ULL, h ^= h >> 29, h *= 0xD6E8FEB86659FD93ULL, h ^= h >> 32;
  return static_cast<double>(h >> 11) * 0x1p-53;
}

/// Smooth noise in 0..1 with features of one unit.
inline double smooth_noise(double x, double y, std::uint64_t seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double a = ease(x - fx), b = ease(y - fy);
  const double top = std::lerp(lattice(ix, iy, seed), lattice(ix + 1, iy, seed), a);
  const double bottom = std::lerp(lattice(ix, iy + 1, seed), lattice(ix + 1, iy + 1, seed), a);
  return std::lerp(top, bottom, b);
}

/// Grey value 0..255 of a texture with features from `size` to four times that.
inline std::uint8_t texture(double x, double y, double size, std::uint64_t seed) {
  const double value = 0.5 * smooth_noise(x / size, y / size, seed) +
                       0.3 * smooth_noise(x / size / 2, y / size / 2, seed + 1) +
                       0.2 * smooth_noise(x / size / 4, y / size / 4, seed + 2);
  return static_cast<std::uint8_t>(std::lround(255 * value));
}

inline hal::GrayImage image(int width, int height, const std::function<std::uint8_t(int, int)>& grey) {
  hal::GrayImage out{width, height, {}};
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) out.pixels.push_back(grey(u, v));
  return out;
}

/// The direction (z = 1) that a raw pixel looks in: Newton-free, by fixed-point iteration on the distortion.
inline Eigen::Vector3d ray(const CameraIntrinsics& c, double u, double v) {
  CameraIntrinsics ideal = c;
  ideal.k1 = ideal.k2 = ideal.p1 = ideal.p2 = ideal.k3 = 0;
  const Eigen::Vector2d pixel(u, v);
  Eigen::Vector2d undistorted = pixel;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d p((undistorted.x() - c.cx) / c.fx, (undistorted.y() - c.cy) / c.fy, 1);
    undistorted += pixel - c.project(p);
  }
  return {(undistorted.x() - c.cx) / c.fx, (undistorted.y() - c.cy) / c.fy, 1};
}

/// What a rig's raw images show of a textured plane `normal` . x = `offset` (left frame, [m]).
inline hal::StereoFrame plane_seen_by(const StereoRig& rig, const Eigen::Vector3d& normal, double offset,
                                      std::uint64_t seed = 1) {
  const Eigen::Isometry3d left_from_right = rig.right_from_left.inverse();
  const auto look = [&](const CameraIntrinsics& camera, const Eigen::Isometry3d& left_from_camera) {
    return image(camera.width, camera.height, [&](int u, int v) {
      const Eigen::Vector3d from = left_from_camera.translation();
      const Eigen::Vector3d along = left_from_camera.linear() * ray(camera, u, v);
      const Eigen::Vector3d p = from + along * (offset - normal.dot(from)) / normal.dot(along);
      return texture(p.x(), p.y(), 3 * offset / camera.fx, seed);
    });
  };
  hal::StereoFrame frame;
  frame.left = look(rig.left, Eigen::Isometry3d::Identity());
  frame.right = look(rig.right, left_from_right);
  return frame;
}

/// The folder with real inputs, or nothing where the variable is not set.
inline std::filesystem::path data_folder() {
  const char* folder = std::getenv("HEADWAY_DATA");
  return folder ? folder : "";
}

}  // namespace headway::vision::test
