#include "synthetic_room.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace headway::nav {
namespace {

constexpr double kBaseline = 0.144;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where a ray enters and leaves a box.
struct Crossing {
  double enter = -kInfinity, leave = kInfinity;
};
Crossing cross(const SolidBox& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  Crossing c;
  for (int k = 0; k < 3; ++k) {
    double a = (box.lowest[k] - origin[k]) / direction[k], b = (box.highest[k] - origin[k]) / direction[k];
    if (direction[k] == 0) {
      const bool between = origin[k] >= box.lowest[k] && origin[k] <= box.highest[k];
      a = between ? -kInfinity : kInfinity;
      b = kInfinity;
    }
    if (a > b) std::swap(a, b);
    c.enter = std::max(c.enter, a);
    c.leave = std::min(c.leave, b);
  }
  return c;
}

/// Signed distance from a box, negative inside.
double distance(const SolidBox& box, const Eigen::Vector3d& p) {
  const Eigen::Vector3d out = (box.lowest - p).cwiseMax(p - box.highest);
  return out.cwiseMax(0).norm() + std::min(0.0, out.maxCoeff());
}

/// Standard normal noise, constant-variance, correlated over about `correlation` pixels.
std::vector<double> noise_field(int width, int height, int correlation, std::mt19937_64& random) {
  const int c = std::max(correlation, 1);
  const int gw = width / c + 2, gh = height / c + 2;
  std::vector<double> grid(static_cast<std::size_t>(gw * gh));
  for (double& g : grid) g = normal(random);
  std::vector<double> field(static_cast<std::size_t>(width * height));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double a = (u % c) / static_cast<double>(c), b = (v % c) / static_cast<double>(c);
      const auto at = [&](int i, int j) {
        return grid[static_cast<std::size_t>((v / c + j) * gw + u / c + i)];
      };
      const double w[4] = {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
      const double sum = w[0] * at(0, 0) + w[1] * at(1, 0) + w[2] * at(0, 1) + w[3] * at(1, 1);
      field[static_cast<std::size_t>(v * width + u)] =
          sum / std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
    }
  }
  return field;
}

}  // namespace

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }
double normal(std::mt19937_64& random) {
  const double r = std::sqrt(-2 * std::log(1 - uniform(random)));
  return r * std::cos(2 * std::numbers::pi * uniform(random));
}

SyntheticRoom SyntheticRoom::furnished() {
  SyntheticRoom room;
  room.solids = {
      {{1.22, -0.61, 0.68}, {2.03, 0.83, 0.73}},    // table top
      {{1.26, -0.57, 0.0}, {1.32, -0.51, 0.68}},    // two of its legs
      {{1.26, 0.73, 0.0}, {1.32, 0.79, 0.68}},      //
      {{0.81, -1.93, 0.0}, {1.62, -1.21, 0.92}},    // crate
      {{-2.61, 0.93, 0.0}, {-2.18, 2.44, 1.83}},    // shelf at the wall
      {{1.085, 1.415, 0.0}, {1.115, 1.445, 2.51}},  // pole, 3 cm
  };
  return room;
}

double SyntheticRoom::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  double nearest = cross(walls, origin, direction).leave;
  for (const SolidBox& box : solids) {
    const Crossing c = cross(box, origin, direction);
    if (c.enter <= c.leave && c.enter > 0) nearest = std::min(nearest, c.enter);
  }
  return nearest;
}

double SyntheticRoom::clearance(const Eigen::Vector3d& point) const {
  double least = -distance(walls, point);
  for (const SolidBox& box : solids) least = std::min(least, distance(box, point));
  return least;
}

vision::PinholeCamera camera_of(int width, int height, double horizontal_field) {
  return {width, height, width / (2 * std::tan(horizontal_field / 2)), (width - 1) / 2.0, (height - 1) / 2.0};
}

Eigen::Isometry3d camera_pose(const Eigen::Vector3d& position, double yaw, double down) {
  Eigen::Matrix3d body_from_optical;
  body_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                  Eigen::AngleAxisd(down, Eigen::Vector3d::UnitY()).toRotationMatrix() * body_from_optical;
  pose.translation() = position;
  return pose;
}

vision::RangeView look(const SyntheticRoom& room, const vision::PinholeCamera& camera,
                       const Eigen::Isometry3d& map_from_camera, const Noise& noise, double sigma,
                       double near, double far) {
  std::mt19937_64 random(noise.seed);
  const std::vector<double> errors = noise_field(camera.width, camera.height, noise.correlation, random);
  vision::RangeView view{camera, near, far, {}, {}};
  view.depth.resize(errors.size());
  view.sigma_depth.resize(errors.size());
  const double per_pixel = 1 / (camera.focal * kBaseline);  // inverse depth per pixel of disparity
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t i = view.index(u, v);
      const Eigen::Vector3d ray = map_from_camera.linear() * camera.point(u, v, 1);
      const double error = noise.disparity_sigma * std::clamp(errors[i], -noise.largest, noise.largest);
      double w = 1 / room.cast(map_from_camera.translation(), ray) + per_pixel * error;
      if (uniform(random) < noise.outliers) w = 1 / far + uniform(random) * (1 / near - 1 / far);
      const double z = w > 0 ? 1 / w : kInfinity;
      const bool known = z >= near && z <= far;
      constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
      view.depth[i] = known ? static_cast<float>(z) : kUnknown;
      view.sigma_depth[i] = known ? static_cast<float>(sigma * per_pixel * z * z) : kUnknown;
    }
  }
  return view;
}

}  // namespace headway::nav
