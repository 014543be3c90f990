#include "bench/mapping_room.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace headway::bench {
namespace {

using Eigen::AlignedBox3d, Eigen::Vector3d;

constexpr double kBaseline = 0.145, kDisparitySigma = 0.25, kSteps = 16, kMissing = 0.05;
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Vector3d kBall{1.21, -0.83, 0.131};
constexpr double kBallRadius = 0.12;
const Eigen::Vector2d kPole{0.43, 0.87};
constexpr double kPoleRadius = 0.015;

/// Where a ray enters and leaves a box; it enters after it leaves when it misses.
struct Crossing {
  double enter = -kInfinity, leave = kInfinity;
};
Crossing cross(const AlignedBox3d& box, const Vector3d& origin, const Vector3d& direction) {
  Crossing c;
  for (int k = 0; k < 3; ++k) {
    if (direction[k] == 0) {
      if (origin[k] < box.min()[k] || origin[k] > box.max()[k]) return {kInfinity, -kInfinity};
      continue;
    }
    const double a = (box.min()[k] - origin[k]) / direction[k], b = (box.max()[k] - origin[k]) / direction[k];
    c.enter = std::max(c.enter, std::min(a, b));
    c.leave = std::min(c.leave, std::max(a, b));
  }
  return c;
}

/// Where a ray first meets a sphere, or a circle in two dimensions; infinite when it misses.
template <class Vector>
double meets_round(const Vector& from_centre, const Vector& direction, double radius) {
  const double a = direction.squaredNorm(), b = from_centre.dot(direction),
               c = from_centre.squaredNorm() - radius * radius, d = b * b - a * c;
  if (a == 0 || d <= 0) return kInfinity;
  const double t = (-b - std::sqrt(d)) / a;
  return t > 0 ? t : kInfinity;
}

double signed_distance(const AlignedBox3d& box, const Vector3d& p) {
  const Vector3d out = (box.min() - p).cwiseMax(p - box.max());
  return out.cwiseMax(0).norm() + std::min(0.0, out.maxCoeff());
}

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }
double normal(std::mt19937_64& random) {
  const double r = std::sqrt(-2 * std::log(1 - uniform(random)));
  return r * std::cos(2 * std::numbers::pi * uniform(random));
}

/// One pass of a Gaussian along rows (or, `down`, along columns) that keeps the variance of white noise.
std::vector<double> blurred(const std::vector<double>& in, int width, int height, double sigma, bool down) {
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> kernel;
  double squares = 0;
  for (int i = -reach; i <= reach; ++i) {
    kernel.push_back(std::exp(-i * i / (2 * sigma * sigma)));
    squares += kernel.back() * kernel.back();
  }
  for (double& k : kernel) k /= std::sqrt(squares);
  std::vector<double> out(in.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int i = -reach; i <= reach; ++i) {
        const int u = down ? x : (x + i + width) % width, v = down ? (y + i + height) % height : y;
        sum += kernel[static_cast<std::size_t>(i + reach)] * in[static_cast<std::size_t>(v * width + u)];
      }
      out[static_cast<std::size_t>(y * width + x)] = sum;
    }
  }
  return out;
}

std::vector<double> noise_field(int width, int height, double blur, std::mt19937_64& random) {
  std::vector<double> field(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (double& value : field) value = normal(random);
  if (blur <= 0) return field;
  return blurred(blurred(field, width, height, blur, false), width, height, blur, true);
}

Eigen::Isometry3d gaze(const Vector3d& head, double pan, double tilt) {
  Eigen::Matrix3d map_from_optical;
  map_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(pan, Vector3d::UnitZ()).toRotationMatrix() *
                  Eigen::AngleAxisd(tilt, Vector3d::UnitY()).toRotationMatrix() * map_from_optical;
  constexpr double kNeck = 0.08;  // from where the head turns to the camera
  pose.translation() = head + kNeck * pose.linear().col(2);
  return pose;
}

vision::RangeView look(const Room& room, const vision::PinholeCamera& camera, const Eigen::Isometry3d& pose,
                       const StereoNoise& noise, std::mt19937_64& random) {
  const std::vector<double> errors = noise_field(camera.width, camera.height, noise.blur, random);
  vision::RangeView view{camera, kNearest, kFarthest, {}, {}};
  view.depth.assign(errors.size(), std::numeric_limits<float>::quiet_NaN());
  view.sigma_depth = view.depth;
  const double scale = camera.focal * kBaseline;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t i = view.index(u, v);
      if (uniform(random) < kMissing) continue;
      double disparity = scale / room.cast(pose.translation(), pose.linear() * camera.point(u, v, 1));
      disparity += kDisparitySigma * errors[i];
      if (uniform(random) < noise.outliers) disparity = scale / (0.8 + 4.2 * uniform(random));
      disparity = std::round(disparity * kSteps) / kSteps;
      if (disparity <= 1 || scale / disparity < kNearest) continue;
      const double z = scale / disparity;
      view.depth[i] = static_cast<float>(z);
      view.sigma_depth[i] = static_cast<float>(z * z * kDisparitySigma / scale);
    }
  }
  return view;
}

}  // namespace

Room::Room() : walls_(Vector3d(-3.013, -3.007, 0.011), Vector3d(3.017, 3.009, 2.987)) {
  const auto add = [&](const Vector3d& low, const Vector3d& high) { boxes_.emplace_back(low, high); };
  add({1.013, -0.607, 0.713}, {1.709, 0.603, 0.743});  // a table's top, 3 cm thick, and its legs
  for (const double x : {1.033, 1.647})
    for (const double y : {-0.587, 0.543}) add({x, y, 0}, {x + 0.042, y + 0.042, 0.713});
  add({1.253, -0.217, 0.743}, {1.507, 0.111, 0.957});  // on it a box
  add({1.303, 0.253, 0.743}, {1.367, 0.317, 0.871});   // and a mug
  add({2.507, 1.203, 0}, {3.017, 2.607, 1.813});       // shelf
  add({-0.507, -2.603, 0}, {0.713, -1.907, 0.453});    // bench
  add({0.213, 1.507, 0}, {0.809, 2.303, 0.907});       // cabinet
  add({2.103, -2.403, 0}, {2.807, -1.703, 0.127});     // two steps of a stair
  add({2.303, -2.403, 0.127}, {2.807, -1.703, 0.243});
  add({-0.907, 0.693, 0}, {-0.813, 1.203, 1.187});  // partition
}

double Room::cast(const Vector3d& origin, const Vector3d& direction) const {
  double nearest = cross(walls_, origin, direction).leave;
  for (const AlignedBox3d& box : boxes_) {
    const Crossing c = cross(box, origin, direction);
    if (c.enter < c.leave && c.enter > 0) nearest = std::min(nearest, c.enter);
  }
  nearest = std::min(nearest, meets_round<Vector3d>(origin - kBall, direction, kBallRadius));
  return std::min(nearest,
                  meets_round<Eigen::Vector2d>(origin.head<2>() - kPole, direction.head<2>(), kPoleRadius));
}

double Room::clearance(const Vector3d& point) const {
  double least = -signed_distance(walls_, point);
  for (const AlignedBox3d& box : boxes_) least = std::min(least, signed_distance(box, point));
  least = std::min(least, (point - kBall).norm() - kBallRadius);
  return std::min(least, (point.head<2>() - kPole).norm() - kPoleRadius);
}

bool Room::on_pole(const Vector3d& centre, double edge) const {
  const double apart = (centre.head<2>() - kPole).cwiseAbs().maxCoeff();
  return apart < kPoleRadius + edge / 2 && centre.z() > 0.1 && centre.z() < 2.9;
}

std::vector<PosedView> look_around(const Room& room, const HeadCamera& camera, const StereoNoise& noise) {
  const vision::PinholeCamera c{camera.width, camera.height,
                                camera.width / 2.0 / std::tan(camera.field * kDegree / 2),
                                (camera.width - 1) / 2.0, (camera.height - 1) / 2.0};
  std::mt19937_64 random(noise.seed);
  std::vector<PosedView> views;
  for (const double tilt : {-30, 10, 45}) {
    for (const double pan : {-45, 0, 45}) {
      const Eigen::Isometry3d pose = gaze(camera.head, pan * kDegree, tilt * kDegree);
      views.push_back({look(room, c, pose, noise, random), pose});
    }
  }
  return views;
}

}  // namespace headway::bench
