#include "nav/floor_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "hal/error.h"

namespace headway::nav {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

constexpr double kMostLookedAt = 8000;  // points of one view
constexpr float kLeastWeight = 0.8F;    // of a point, as for the map
constexpr double kNearest = 0.2;        // [m] from the camera's foot: nearer is the robot itself
constexpr double kFinest = 0.004;       // [m] standard deviation of any height: floors are not flat
constexpr double kBand = 0.05;          // [m] beside what tilt and height may raise a floor point
constexpr double kWithin = 3;           // sigma, off the plane
constexpr double kRunLength = 6;        // samples beside each other whose errors are alike
constexpr double kLeastShare = 0.7;     // of the points near the floor on one plane
constexpr double kMostBelow = 0.05;     // share of points clearly below it
constexpr double kClearlyBelow = 0.03;  // [m]
// How far off the plane points may lie in each round [m], or kWithin sigma.
constexpr std::array kRounds{0.12, 0.06, 0.04, 0.025, 0.025};

}  // namespace

void FloorFitConfig::validate() const {
  const auto check = [](const char* name, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    throw InputError("floor fit: " + std::string(name) + ": " + std::to_string(value) + ", expected " +
                     std::to_string(lowest) + " to " + std::to_string(highest));
  };
  check("range", range, 0.5, 20);
  check("widest_tilt", widest_tilt, 0.001, 0.2);
  check("greatest_height", greatest_height, 0.001, 0.5);
  check("least_points", least_points, 10, 1e6);
}

FloorFitter::FloorFitter(const FloorFitConfig& config) : config_(config) { config_.validate(); }

/// How high a point lies above a plane [m].
double FloorFitter::above(const FloorPlane& plane, const Point& point) {
  const Vector3d values(plane.height, plane.slope.x(), plane.slope.y());
  return (point.right - point.row.dot(values)) * point.floor_depth;
}

void FloorFitter::take(const vision::RangeView& view, const Eigen::Isometry3d& map_from_view) {
  const double pixels = static_cast<double>(view.depth.size());
  const int step = std::max(1, static_cast<int>(std::sqrt(pixels / kMostLookedAt)));
  const double eye = map_from_view.translation().z();
  points_.clear();
  lower_ = 0;
  for (int v = step / 2; v < view.camera.height; v += step) {
    for (int u = step / 2; u < view.camera.width; u += step) {
      const std::size_t i = view.index(u, v);
      const auto z = static_cast<double>(view.depth[i]);
      const auto sigma_z = static_cast<double>(view.sigma_depth[i]);
      if (!(z > 0 && std::isfinite(z) && sigma_z > 0 && std::isfinite(sigma_z))) continue;
      if (!view.weight.empty() && !(view.weight[i] >= kLeastWeight)) continue;
      const Vector3d ray = map_from_view.linear() * view.camera.point(u, v, 1);
      const double floor_depth = eye / -ray.z(), distance = floor_depth * ray.head<2>().norm();
      if (!(floor_depth >= view.near && floor_depth <= view.far)) continue;
      if (distance < kNearest || distance > config_.range) continue;
      // z (eye / z + ray.z) is the point's height: eye + z ray.z = height + z slope . ray, over z.
      const double sigma = std::hypot(eye * sigma_z / (z * z), kFinest / floor_depth);
      const Point point{{1 / z, ray.x(), ray.y()}, eye / z + ray.z(), sigma, floor_depth};
      const double height = point.right * floor_depth;
      const double reach = kBand + config_.greatest_height + config_.widest_tilt * distance;
      lower_ += height < -reach;
      if (std::abs(height) <= reach) points_.push_back(point);
    }
  }
}

FloorFit FloorFitter::fit(const vision::RangeView& view, const Eigen::Isometry3d& map_from_view) {
  take(view, map_from_view);
  FloorFit fit;
  fit.plane.foot = map_from_view.translation().head<2>();
  if (points_.size() < static_cast<std::size_t>(config_.least_points)) return fit;
  for (const double widest : kRounds) {
    // What is known beforehand: a floor is level, under the feet.
    const Vector3d expected(config_.greatest_height, config_.widest_tilt, config_.widest_tilt);
    Matrix3d information = expected.cwiseAbs2().cwiseInverse().asDiagonal();
    Vector3d right = Vector3d::Zero();
    std::size_t taken = 0;
    for (const Point& point : points_) {
      const double off = above(fit.plane, point), sigma = point.sigma * point.floor_depth;
      if (std::abs(off) > std::max(widest, kWithin * sigma)) continue;
      const double weight = 1 / (kRunLength * point.sigma * point.sigma);
      information += weight * point.row * point.row.transpose();
      right += weight * point.right * point.row;
      ++taken;
    }
    fit.plane.covariance = information.inverse();
    const Vector3d values = fit.plane.covariance * right;
    fit.plane.height = values.x();
    fit.plane.slope = values.tail<2>();
    fit.plane.points = taken;
  }
  fit.sight = judge(fit.plane);
  return fit;
}

FloorSight FloorFitter::judge(const FloorPlane& plane) const {
  const auto all = static_cast<double>(points_.size());
  if (plane.points < static_cast<std::size_t>(config_.least_points)) return FloorSight::kTooFew;
  if (std::abs(plane.height) > config_.greatest_height) return FloorSight::kTooHigh;
  if (plane.slope.norm() > config_.widest_tilt) return FloorSight::kTooSteep;
  if (static_cast<double>(plane.points) < kLeastShare * all) return FloorSight::kScattered;
  const auto below = std::ranges::count_if(points_, [&](const Point& point) {
    return above(plane, point) < -std::max(kClearlyBelow, kWithin * point.sigma * point.floor_depth);
  });
  if (static_cast<double>(below) + static_cast<double>(lower_) > kMostBelow * all)
    return FloorSight::kNotLowest;
  return FloorSight::kPlane;
}

}  // namespace headway::nav
