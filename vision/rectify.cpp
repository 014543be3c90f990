#include "vision/rectify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "hal/error.h"
#include "vision/cv_image.h"

namespace headway::vision {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// True for images that need no resampling: ideal cameras side by side. Their principal points may differ
// along x.
bool is_rectified(const StereoRig& rig) {
  const CameraIntrinsics &l = rig.left, &r = rig.right;
  const Eigen::Vector3d t = rig.right_from_left.translation();
  return !l.distorts() && !r.distorts() && l.fx == l.fy && r.fx == r.fy && l.fx == r.fx && l.cy == r.cy &&
         rig.right_from_left.linear().isIdentity(1e-12) && t.y() == 0 && t.z() == 0;
}

RectifiedRig limits_of(const StereoRig& rig) {
  RectifiedRig out;
  out.baseline = rig.baseline();
  out.nearest = rig.nearest, out.farthest = rig.farthest;
  out.disparity_sigma = rig.disparity_sigma;
  return out;
}

struct Rotations {
  Matrix3d left, right;  // rectified from raw
};

// Half of the turn between the cameras goes to each; then both turn until the baseline lies along x
// (Bouguet's way, and OpenCV's).
Rotations rectifying(const StereoRig& rig) {
  Eigen::AngleAxisd half(rig.right_from_left.linear());
  half.angle() *= -0.5;
  const Vector3d left_from_right = half * rig.right_from_left.translation();
  const Matrix3d level =
      Eigen::Quaterniond::FromTwoVectors(left_from_right, -Vector3d::UnitX()).toRotationMatrix();
  return {level * half.inverse().toRotationMatrix(), level * half.toRotationMatrix()};
}

// What a camera shows, as a rectangle in the plane z = 1 of its rectified frame.
struct Window {
  double left, right, top, bottom;
  Window common(const Window& o) const {
    return {std::max(left, o.left), std::min(right, o.right), std::max(top, o.top),
            std::min(bottom, o.bottom)};
  }
};

// Beyond 63 deg from the axis a flat image spends most of its pixels on its rim.
constexpr double kWidest = 2;

// The rectangle inside the image's edges. A pixel beyond the image circle lies beyond the widest angle too.
Window window(const CameraIntrinsics& c, const Matrix3d& rectified_from_raw) {
  Window inner{-kWidest, kWidest, -kWidest, kWidest};
  const auto place = [&](double u, double v) -> std::optional<Vector2d> {
    const auto ray = c.unproject({u, v});
    if (!ray) return std::nullopt;
    const Vector3d turned = rectified_from_raw * *ray;
    if (turned.z() < 0.1) return std::nullopt;
    return turned.hnormalized();
  };
  constexpr int kSteps = 128;
  const double right = c.width - 1, bottom = c.height - 1;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = right * i / kSteps, v = bottom * i / kSteps;
    if (const auto p = place(0, v)) inner.left = std::max(inner.left, p->x());
    if (const auto p = place(right, v)) inner.right = std::min(inner.right, p->x());
    if (const auto p = place(u, 0)) inner.top = std::max(inner.top, p->y());
    if (const auto p = place(u, bottom)) inner.bottom = std::min(inner.bottom, p->y());
  }
  return inner;
}

// The camera of this size that shows as much as fits into the window. Throws InputError when there is none.
PinholeCamera camera_in(const Window& w, int width, int height, const std::string& name) {
  if (!(w.right - w.left > 1e-3 && w.bottom - w.top > 1e-3))
    throw InputError(
        fmt::format("rig {}: no common image is left after rectification; check the calibration", name));
  PinholeCamera camera;
  camera.width = width, camera.height = height;
  camera.focal = std::max((width - 1) / (w.right - w.left), (height - 1) / (w.bottom - w.top));
  camera.cx = (width - 1) / 2.0 - camera.focal * (w.left + w.right) / 2;
  camera.cy = (height - 1) / 2.0 - camera.focal * (w.top + w.bottom) / 2;
  return camera;
}

}  // namespace

struct Rectifier::Tables {
  struct Side {
    CameraIntrinsics camera;
    Matrix3d rectified_from_raw;
    cv::Mat xy, fraction;  // positions to look up, in the fixed-point form of cv::convertMaps
  };
  Side left, right;

  static void fill(Side& side, const PinholeCamera& rectified) {
    cv::Mat places(rectified.height, rectified.width, CV_32FC2);
    const Matrix3d raw_from_rectified = side.rectified_from_raw.transpose();
    for (int v = 0; v < rectified.height; ++v)
      for (int u = 0; u < rectified.width; ++u) {
        const Vector2d raw = side.camera.project(raw_from_rectified * rectified.point(u, v, 1));
        places.at<cv::Vec2f>(v, u) = {static_cast<float>(raw.x()), static_cast<float>(raw.y())};
      }
    cv::convertMaps(places, cv::noArray(), side.xy, side.fraction, CV_16SC2);
  }
};

Rectifier::Rectifier(const StereoRig& rig, double scale) : raw_(rig), rig_(limits_of(rig)) {
  require_usable(rig);
  if (!(scale >= 0.1 && scale <= 1))
    throw InputError(fmt::format("scale: {}, expected 0.1 (small and fast) to 1 (full size)", scale));
  const int width = static_cast<int>(std::lround(rig.left.width * scale));
  const int height = static_cast<int>(std::lround(rig.left.height * scale));
  if (scale == 1 && is_rectified(rig)) {
    rig_.camera = {width, height, rig.left.fx, rig.left.cx, rig.left.cy};
    rig_.disparity_offset = rig.right.cx - rig.left.cx;
    return;
  }
  const auto [left, right] = rectifying(rig);
  rig_.camera = camera_in(window(rig.left, left).common(window(rig.right, right)), width, height, rig.name);
  rectified_from_left_.linear() = left;
  rectified_from_right_.linear() = right;
  auto tables = std::make_shared<Tables>();
  tables->left = {rig.left, left, {}, {}};
  tables->right = {rig.right, right, {}, {}};
  Tables::fill(tables->left, rig_.camera);
  Tables::fill(tables->right, rig_.camera);
  tables_ = std::move(tables);
}

Vector2d Rectifier::rectified(const CameraIntrinsics& camera, const Eigen::Isometry3d& turn,
                              const Vector2d& raw) const {
  if (passes_through()) return raw;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto ray = camera.unproject(raw);
  if (!ray) return {kNone, kNone};
  const Vector3d turned = turn * *ray;
  if (!(turned.z() > 0)) return {kNone, kNone};
  return rig_.camera.focal * turned.hnormalized() + Vector2d(rig_.camera.cx, rig_.camera.cy);
}

Vector2d Rectifier::rectified_left(const Vector2d& raw) const {
  return rectified(raw_.left, rectified_from_left_, raw);
}

Vector2d Rectifier::rectified_right(const Vector2d& raw) const {
  return rectified(raw_.right, rectified_from_right_, raw);
}

bool Rectifier::accepts(const hal::GrayImage& left, const hal::GrayImage& right) const {
  const auto fits = [](const hal::GrayImage& image, const CameraIntrinsics& camera) {
    return complete(image) && image.width == camera.width && image.height == camera.height;
  };
  return fits(left, raw_.left) && fits(right, raw_.right);
}

void Rectifier::rectify(const hal::GrayImage& left, const hal::GrayImage& right, hal::GrayImage& left_out,
                        hal::GrayImage& right_out, hal::TwoProcessors& processors) const {
  if (passes_through()) {
    left_out = left, right_out = right;
    return;
  }
  const auto look_up = [this](const hal::GrayImage& in, const Tables::Side& side, hal::GrayImage& out) {
    resize(out, rig_.camera.width, rig_.camera.height);
    cv::Mat result = as_mat(out);
    cv::remap(as_mat(in), result, side.xy, side.fraction, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  };
  processors.both([&] { look_up(left, tables_->left, left_out); },
                  [&] { look_up(right, tables_->right, right_out); });
}

}  // namespace headway::vision
