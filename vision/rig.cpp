#include "vision/rig.h"

#include <cmath>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::vision {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = 0.017453292519943295;

// The lens's radial curve must rise up to the image's corner: where it turns back, two rays meet in one pixel
// and the image cannot be undistorted.
bool folds_over(const CameraIntrinsics& c) {
  const double x = std::max(c.cx, c.width - c.cx) / c.fx, y = std::max(c.cy, c.height - c.cy) / c.fy;
  const double corner = std::hypot(x, y);
  constexpr double kStep = 1e-3, kWidest = 20;  // tangent of the angle from the axis
  for (double r = 0; r < kWidest; r += kStep) {
    const double r2 = r * r;
    if (r * (1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3))) >= corner) return false;
    if (1 + r2 * (3 * c.k1 + r2 * (5 * c.k2 + r2 * 7 * c.k3)) < 0.01) return true;
  }
  return true;
}

bool within(double value, double lowest, double highest) { return value >= lowest && value <= highest; }

std::optional<RigFault> camera_fault(const std::string& side, const CameraIntrinsics& c) {
  if (!within(c.width, 16, 16384) || !within(c.height, 16, 16384))
    return RigFault{"size", fmt::format("{} x {}, expected 16 to 16384 px each way", c.width, c.height)};
  if (!within(c.fx, 1, 1e6) || !within(c.fy, 1, 1e6))
    return RigFault{side + ".focal", fmt::format("[{}, {}], expected 1 to 1e6 px", c.fx, c.fy)};
  if (!within(c.cx, 0, c.width) || !within(c.cy, 0, c.height))
    return RigFault{side + ".centre", fmt::format("[{}, {}] lies outside the image of {} x {} px", c.cx, c.cy,
                                                  c.width, c.height)};
  for (const double k : {c.k1, c.k2, c.p1, c.p2, c.k3})
    if (!within(k, -100, 100))
      return RigFault{side + ".distortion", fmt::format("{}, expected -100 to 100", k)};
  if (folds_over(c))
    return RigFault{
        side + ".distortion",
        "folds the image over before its corner, which no lens does; check order and signs (k1 k2 p1 p2 k3)"};
  return std::nullopt;
}

double horizontal_field(const CameraIntrinsics& c) {
  return std::atan((c.width - c.cx) / c.fx) + std::atan(c.cx / c.fx);
}

std::optional<RigFault> arrangement_fault(const StereoRig& rig) {
  const Eigen::Matrix3d rotation = rig.right_from_left.linear();
  const Vector3d t = rig.right_from_left.translation();
  if (!rotation.allFinite() ||
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-3 ||
      rotation.determinant() < 0)
    return RigFault{"right_from_left",
                    "its rotation is not one (columns of length 1, at right angles, right-handed)"};
  if (!t.allFinite() || !(t.norm() > 0.02 && t.norm() < 1))
    return RigFault{"right_from_left",
                    fmt::format("the cameras are {:.4g} m apart, expected 0.02 to 1 m (metres?)", t.norm())};
  const Vector3d right = -rotation.transpose() * t;  // the right camera's place in the left frame
  if (right.x() < 0)
    return RigFault{
        "right_from_left",
        "puts the right camera to the left of the left one; swap the cameras, or invert the transform"};
  if (right.x() < 0.9 * right.norm())
    return RigFault{
        "right_from_left",
        fmt::format("puts the right camera at [{:.3f}, {:.3f}, {:.3f}] m in the left frame (x right, y down, "
                    "z forward), expected beside it along x",
                    right.x(), right.y(), right.z())};
  const double turned = std::acos(std::clamp((rotation.trace() - 1) / 2, -1.0, 1.0));
  if (turned > 0.5 * std::min(horizontal_field(rig.left), horizontal_field(rig.right)))
    return RigFault{"right_from_left",
                    fmt::format("turns the cameras {:.1f} deg apart, so that they hardly see the same",
                                turned / kDegree)};
  return std::nullopt;
}

std::optional<RigFault> depth_fault(const StereoRig& rig) {
  if (!within(rig.nearest, 0.05, 100))
    return RigFault{"nearest", fmt::format("{} m, expected 0.05 to 100 m", rig.nearest)};
  if (!(rig.farthest > rig.nearest && rig.farthest <= 1000))
    return RigFault{"farthest", fmt::format("{} m, expected more than nearest ({} m) and up to 1000 m",
                                            rig.farthest, rig.nearest)};
  if (!within(rig.disparity_sigma, 0.01, 10))
    return RigFault{"disparity_sigma", fmt::format("{} px, expected 0.01 to 10 px", rig.disparity_sigma)};
  const double shift = rig.left.fx * rig.baseline() / rig.nearest;
  if (shift > 0.9 * rig.left.width)
    return RigFault{"nearest",
                    fmt::format("{} m: images as near as that are shifted by {:.0f} of {} px and hardly "
                                "overlap; expected at least {:.2f} m",
                                rig.nearest, shift, rig.left.width,
                                rig.left.fx * rig.baseline() / (0.9 * rig.left.width))};
  return std::nullopt;
}

}  // namespace

Vector2d CameraIntrinsics::project(const Vector3d& point) const {
  const double x = point.x() / point.z(), y = point.y() / point.z(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
          fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy};
}

std::optional<RigFault> fault_of(const StereoRig& rig) {
  if (auto fault = camera_fault("left", rig.left)) return fault;
  if (auto fault = camera_fault("right", rig.right)) return fault;
  if (rig.left.width != rig.right.width || rig.left.height != rig.right.height)
    return RigFault{"size", fmt::format("left {} x {}, right {} x {} px, expected one size for both",
                                        rig.left.width, rig.left.height, rig.right.width, rig.right.height)};
  if (auto fault = arrangement_fault(rig)) return fault;
  return depth_fault(rig);
}

void require_usable(const StereoRig& rig) {
  if (const auto fault = fault_of(rig))
    throw InputError(fmt::format("rig {}: {}: {}", rig.name, fault->key, fault->what));
}

}  // namespace headway::vision
