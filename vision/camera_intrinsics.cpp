#include "vision/camera_intrinsics.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace headway::vision {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A lens whose image is squeezed further than this counts as turning back.
constexpr double kLeastSlope = 0.01;

// The factor by which a radial lens stretches the distance r from the axis, and its derivative by r^2.
struct Stretch {
  double factor, slope;
  double along(double r2) const { return factor + 2 * r2 * slope; }  // of the distorted distance, by r
};

Stretch stretch(const CameraIntrinsics& c, double r2) {
  const double n = 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double dn = c.k1 + r2 * (2 * c.k2 + r2 * 3 * c.k3);
  if (c.lens != LensModel::kRational) return {n, dn};
  const double d = 1 + r2 * (c.k4 + r2 * (c.k5 + r2 * c.k6));
  const double dd = c.k4 + r2 * (2 * c.k5 + r2 * 3 * c.k6);
  if (!(d > 0)) return {0, 0};  // beyond the pole: no lens
  return {n / d, (dn - dd * n / d) / d};
}

Vector2d distorted(const CameraIntrinsics& c, const Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm(), radial = stretch(c, r2).factor;
  return {x * radial + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x),
          y * radial + c.p1 * (r2 + 2 * y * y) + 2 * c.p2 * x * y};
}

Matrix2d jacobian(const CameraIntrinsics& c, const Vector2d& p) {
  const double x = p.x(), y = p.y();
  const Stretch s = stretch(c, p.squaredNorm());
  const double across = 2 * (s.slope * x * y + c.p1 * x + c.p2 * y);
  Matrix2d j;
  j << s.factor + 2 * s.slope * x * x + 2 * c.p1 * y + 6 * c.p2 * x, across, across,
      s.factor + 2 * s.slope * y * y + 6 * c.p1 * y + 2 * c.p2 * x;
  return j;
}

bool rises_up_to(const CameraIntrinsics& c, double r) {
  constexpr int kSamples = 32;
  for (int i = 1; i <= kSamples; ++i) {
    const double r2 = std::pow(r * i / kSamples, 2);
    if (!(stretch(c, r2).along(r2) > kLeastSlope)) return false;
  }
  return true;
}

// The point at distance 1 along the axis. Newton, with steps that stay on the side of the fold where the lens
// is one.
std::optional<Vector2d> undistorted(const CameraIntrinsics& c, const Vector2d& target) {
  Vector2d p = target;
  for (int halvings = 0; !(jacobian(c, p).determinant() > 0) && halvings < 20; ++halvings) p *= 0.5;
  for (int i = 0; i < 50; ++i) {
    const Vector2d error = distorted(c, p) - target;
    if (!error.allFinite()) return std::nullopt;
    if (error.norm() < 1e-13 * (1 + target.norm()))
      return rises_up_to(c, p.norm()) ? std::optional(p) : std::nullopt;
    Vector2d step = jacobian(c, p).inverse() * error;
    for (int halvings = 0; !(jacobian(c, p - step).determinant() > 0); ++halvings) {
      if (halvings == 20) return std::nullopt;
      step *= 0.5;
    }
    p -= step;
  }
  // What is left is rounding, or a pixel that no ray leads to.
  if ((distorted(c, p) - target).norm() < 1e-9 && rises_up_to(c, p.norm())) return p;
  return std::nullopt;
}

// theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8): Kannala and Brandt 2006, equation 6.
double bent(const CameraIntrinsics& c, double theta) {
  const double t = theta * theta;
  return theta * (1 + t * (c.k1 + t * (c.k2 + t * (c.k3 + t * c.k4))));
}

double bent_slope(const CameraIntrinsics& c, double theta) {
  const double t = theta * theta;
  return 1 + t * (3 * c.k1 + t * (5 * c.k2 + t * (7 * c.k3 + t * 9 * c.k4)));
}

// The angle from the axis: walks out to the bracket that holds it, then closes in by Newton inside the
// bracket.
std::optional<double> unbent(const CameraIntrinsics& c, double target) {
  constexpr double kStep = std::numbers::pi / 64;
  double lower = 0, upper = kStep;
  for (; bent(c, upper) < target; lower = upper, upper += kStep)
    if (!(bent_slope(c, upper) > kLeastSlope) || upper > std::numbers::pi) return std::nullopt;
  double theta = 0.5 * (lower + upper);
  for (int i = 0; i < 60; ++i) {
    const double error = bent(c, theta) - target;
    (error > 0 ? upper : lower) = theta;
    if (std::abs(error) < 1e-14) break;
    const double newton = theta - error / bent_slope(c, theta);
    theta = newton > lower && newton < upper ? newton : 0.5 * (lower + upper);
  }
  return theta <= std::numbers::pi && bent_slope(c, theta) > kLeastSlope ? std::optional(theta)
                                                                         : std::nullopt;
}

}  // namespace

const char* coefficient_names(LensModel lens) {
  switch (lens) {
    case LensModel::kRadialTangential:
      return "k1 k2 p1 p2 k3";
    case LensModel::kRational:
      return "k1 k2 p1 p2 k3 k4 k5 k6";
    case LensModel::kEquidistant:
      return "k1 k2 k3 k4";
  }
  return "";
}

bool CameraIntrinsics::distorts() const {
  const bool radial_tangential = k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0;
  switch (lens) {
    case LensModel::kRadialTangential:
      return radial_tangential;
    case LensModel::kRational:
      return radial_tangential || k4 != 0 || k5 != 0 || k6 != 0;
    case LensModel::kEquidistant:
      return true;
  }
  return true;
}

Vector2d CameraIntrinsics::project(const Vector3d& point) const {
  if (lens != LensModel::kEquidistant) {
    const Vector2d d = distorted(*this, point.head<2>() / point.z());
    return {fx * d.x() + cx, fy * d.y() + cy};
  }
  const double r = point.head<2>().norm();
  if (r == 0) return {cx, cy};
  const Vector2d d = point.head<2>() * (bent(*this, std::atan2(r, point.z())) / r);
  return {fx * d.x() + cx, fy * d.y() + cy};
}

std::optional<Vector3d> CameraIntrinsics::unproject(const Vector2d& pixel) const {
  const Vector2d target((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!target.allFinite()) return std::nullopt;
  if (lens != LensModel::kEquidistant) {
    const auto p = undistorted(*this, target);
    return p ? std::optional<Vector3d>(p->homogeneous().normalized()) : std::nullopt;
  }
  const double r = target.norm();
  if (r == 0) return Vector3d::UnitZ();
  const auto theta = unbent(*this, r);
  if (!theta) return std::nullopt;
  const Vector2d across = target * (std::sin(*theta) / r);
  return Vector3d(across.x(), across.y(), std::cos(*theta));
}

}  // namespace headway::vision
