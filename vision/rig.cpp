#include "vision/rig.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "hal/angle.h"
#include "hal/error.h"

namespace headway::vision {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLargestCoefficient = 1000;
constexpr double kMostPixels = 1 << 25;  // rectifying takes tables of 6 bytes a pixel, for each camera
constexpr double kLeastOverlap = 0.1;    // of one image, at the best distance

// Where the lens's radial curve turns back, two rays meet in one pixel and the image cannot be undistorted.
// The corners of a fisheye image may lie outside its circle.
bool folds_over(const CameraIntrinsics& c) {
  const double right = c.width - 1, bottom = c.height - 1;
  using Pixels = std::array<Vector2d, 4>;
  const Pixels corners{Vector2d(0, 0), {right, 0}, {0, bottom}, {right, bottom}};
  const Pixels edges{Vector2d(0, c.cy), {right, c.cy}, {c.cx, 0}, {c.cx, bottom}};
  const Pixels& pixels = c.lens == LensModel::kEquidistant ? edges : corners;
  return !std::all_of(pixels.begin(), pixels.end(),
                      [&](const Vector2d& p) { return c.unproject(p).has_value(); });
}

bool within(double value, double lowest, double highest) { return value >= lowest && value <= highest; }

std::optional<RigFault> camera_fault(const std::string& side, const CameraIntrinsics& c) {
  if (!within(c.width, 16, 16384) || !within(c.height, 16, 16384))
    return RigFault{"size", fmt::format("{} x {}, expected 16 to 16384 px each way", c.width, c.height)};
  if (static_cast<double>(c.width) * c.height > kMostPixels)
    return RigFault{"size", fmt::format("{} x {}, expected at most {:.0f} megapixels", c.width, c.height,
                                        kMostPixels / 1e6)};
  if (!within(c.fx, 1, 1e6) || !within(c.fy, 1, 1e6))
    return RigFault{side + ".focal", fmt::format("[{}, {}], expected 1 to 1e6 px", c.fx, c.fy)};
  if (!within(c.cx, 0, c.width) || !within(c.cy, 0, c.height))
    return RigFault{side + ".centre", fmt::format("[{}, {}] lies outside the image of {} x {} px", c.cx, c.cy,
                                                  c.width, c.height)};
  for (const double k : {c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6})
    if (!within(k, -kLargestCoefficient, kLargestCoefficient))
      return RigFault{side + ".distortion",
                      fmt::format("{}, expected -{} to {}", k, kLargestCoefficient, kLargestCoefficient)};
  if (folds_over(c))
    return RigFault{
        side + ".distortion",
        fmt::format("folds the image over before its {}, which no lens does; check order and signs ({})",
                    c.lens == LensModel::kEquidistant ? "edge" : "corner", coefficient_names(c.lens))};
  return std::nullopt;
}

// Of a camera whose lens has passed: the middles of its edges have rays.
double horizontal_field(const CameraIntrinsics& c) {
  const Vector3d left = c.unproject({0, c.cy}).value_or(Vector3d::UnitZ());
  const Vector3d right = c.unproject({c.width - 1.0, c.cy}).value_or(Vector3d::UnitZ());
  return std::acos(std::clamp(left.dot(right), -1.0, 1.0));
}

// True where the point falls into the image and the pixel looks at it: the formulas of a lens go on where its
// image ends, and may come back.
bool shows(const CameraIntrinsics& c, const Vector3d& point) {
  if (point.z() <= 0 && c.lens != LensModel::kEquidistant) return false;
  const Vector2d pixel = c.project(point);
  if (!within(pixel.x(), 0, c.width - 1) || !within(pixel.y(), 0, c.height - 1)) return false;
  const auto ray = c.unproject(pixel);
  return ray && ray->dot(point) > 0.999 * point.norm();
}

// The share of one camera's image that the other shows too, of what lies at `distance` [m].
double shared(const CameraIntrinsics& one, const CameraIntrinsics& other,
              const Eigen::Isometry3d& other_from_one, double distance) {
  constexpr int kSteps = 8;
  int seen = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const auto ray =
          one.unproject({(i + 0.5) / kSteps * (one.width - 1), (j + 0.5) / kSteps * (one.height - 1)});
      seen += ray && shows(other, other_from_one * (distance * *ray));
    }
  return seen / static_cast<double>(kSteps * kSteps);
}

// At the best distance, and of the camera that shares more: a wide camera beside a narrow one shares little.
double overlap(const StereoRig& rig) {
  constexpr int kDistances = 5;
  double most = 0;
  for (int i = 0; i < kDistances; ++i) {
    const double distance = rig.nearest * std::pow(rig.farthest / rig.nearest, i / (kDistances - 1.0));
    most = std::max({most, shared(rig.left, rig.right, rig.right_from_left, distance),
                     shared(rig.right, rig.left, rig.right_from_left.inverse(), distance)});
  }
  return most;
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
  const double focal = std::max(rig.left.fx, rig.right.fx), shift = focal * rig.baseline() / rig.nearest;
  if (shift > 0.9 * rig.left.width)
    return RigFault{
        "nearest",
        fmt::format("{} m: images as near as that are shifted by {:.0f} of {} px and hardly "
                    "overlap; expected at least {:.2f} m",
                    rig.nearest, shift, rig.left.width, focal * rig.baseline() / (0.9 * rig.left.width))};
  return std::nullopt;
}

}  // namespace

std::optional<RigFault> fault_of(const StereoRig& rig) {
  if (auto fault = camera_fault("left", rig.left)) return fault;
  if (auto fault = camera_fault("right", rig.right)) return fault;
  if (rig.left.width != rig.right.width || rig.left.height != rig.right.height)
    return RigFault{"size", fmt::format("left {} x {}, right {} x {} px, expected one size for both",
                                        rig.left.width, rig.left.height, rig.right.width, rig.right.height)};
  if (auto fault = arrangement_fault(rig)) return fault;
  if (auto fault = depth_fault(rig)) return fault;
  if (const double common = overlap(rig); common < kLeastOverlap)
    return RigFault{"right_from_left",
                    fmt::format("the cameras share {:.0f} % of their images between nearest and "
                                "farthest, expected at least {:.0f} %",
                                100 * common, 100 * kLeastOverlap)};
  return std::nullopt;
}

void require_usable(const StereoRig& rig) {
  if (const auto fault = fault_of(rig))
    throw InputError(fmt::format("rig {}: {}: {}", rig.name, fault->key, fault->what));
}

}  // namespace headway::vision
