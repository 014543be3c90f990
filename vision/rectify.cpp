#include "vision/rectify.h"

#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "hal/error.h"
#include "vision/cv_image.h"

namespace headway::vision {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Matrix3 = cv::Matx33d;

Matrix3 camera_matrix(const CameraIntrinsics& c) { return {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1}; }
cv::Vec<double, 5> distortion(const CameraIntrinsics& c) { return {c.k1, c.k2, c.p1, c.p2, c.k3}; }

Matrix3d to_eigen(const Matrix3& m) {
  Matrix3d out;
  out << m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2);
  return out;
}
Matrix3 to_cv(const Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

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

}  // namespace

struct Rectifier::Tables {
  struct Side {
    cv::Mat xy, fraction;  // positions to look up, in the fixed-point form of cv::convertMaps
    Matrix3 intrinsics, rotation;
    cv::Vec<double, 5> distortion;
  };
  Side left, right;
  Matrix3 rectified;  // the camera matrix of both rectified images

  Vector2d pixel(const Side& side, const Vector2d& raw) const {
    const std::vector<cv::Point2d> in{{raw.x(), raw.y()}};
    std::vector<cv::Point2d> out;
    cv::undistortPoints(in, out, side.intrinsics, side.distortion, side.rotation, rectified,
                        cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12));
    return {out[0].x, out[0].y};
  }
};

Rectifier::Rectifier(const StereoRig& rig, double scale) : raw_(rig), rig_(limits_of(rig)) {
  require_usable(rig);
  if (!(scale >= 0.1 && scale <= 1))
    throw InputError(fmt::format("scale: {}, expected 0.1 (small and fast) to 1 (full size)", scale));
  PinholeCamera& camera = rig_.camera;
  camera.width = static_cast<int>(std::lround(rig.left.width * scale));
  camera.height = static_cast<int>(std::lround(rig.left.height * scale));
  if (scale == 1 && is_rectified(rig)) {
    camera.focal = rig.left.fx, camera.cx = rig.left.cx, camera.cy = rig.left.cy;
    rig_.disparity_offset = rig.right.cx - rig.left.cx;
    return;
  }
  auto tables = std::make_shared<Tables>();
  try {
    const cv::Size raw_size(rig.left.width, rig.left.height), size(camera.width, camera.height);
    tables->left.intrinsics = camera_matrix(rig.left), tables->left.distortion = distortion(rig.left);
    tables->right.intrinsics = camera_matrix(rig.right), tables->right.distortion = distortion(rig.right);
    cv::Matx34d projection_left, projection_right;
    cv::Matx44d unused;
    const Eigen::Vector3d t = rig.right_from_left.translation();
    cv::stereoRectify(tables->left.intrinsics, tables->left.distortion, tables->right.intrinsics,
                      tables->right.distortion, raw_size, to_cv(rig.right_from_left.linear()),
                      cv::Vec3d(t.x(), t.y(), t.z()), tables->left.rotation, tables->right.rotation,
                      projection_left, projection_right, unused, cv::CALIB_ZERO_DISPARITY, 0, size);
    tables->rectified = projection_left.get_minor<3, 3>(0, 0);
    for (Tables::Side* side : {&tables->left, &tables->right})
      cv::initUndistortRectifyMap(side->intrinsics, side->distortion, side->rotation, tables->rectified, size,
                                  CV_16SC2, side->xy, side->fraction);
  } catch (const cv::Exception& e) {
    throw InputError(fmt::format("rig {}: cannot be rectified ({}); check the calibration", rig.name, e.err));
  }
  const Matrix3& k = tables->rectified;
  camera.focal = k(0, 0), camera.cx = k(0, 2), camera.cy = k(1, 2);
  if (!(camera.focal > 1) || !std::isfinite(camera.cx + camera.cy) ||
      std::abs(k(0, 0) - k(1, 1)) > 1e-9 * k(0, 0))
    throw InputError(
        fmt::format("rig {}: no common image is left after rectification; check the calibration", rig.name));
  rectified_from_left_.linear() = to_eigen(tables->left.rotation);
  tables_ = std::move(tables);
}

Vector2d Rectifier::rectified_left(const Vector2d& raw) const {
  return tables_ ? tables_->pixel(tables_->left, raw) : raw;
}

Vector2d Rectifier::rectified_right(const Vector2d& raw) const {
  return tables_ ? tables_->pixel(tables_->right, raw) : raw;
}

bool Rectifier::accepts(const hal::GrayImage& left, const hal::GrayImage& right) const {
  const auto fits = [](const hal::GrayImage& image, const CameraIntrinsics& camera) {
    return complete(image) && image.width == camera.width && image.height == camera.height;
  };
  return fits(left, raw_.left) && fits(right, raw_.right);
}

void Rectifier::rectify(const hal::GrayImage& left, const hal::GrayImage& right, hal::GrayImage& left_out,
                        hal::GrayImage& right_out) const {
  if (passes_through()) {
    left_out = left, right_out = right;
    return;
  }
  const auto look_up = [this](const hal::GrayImage& in, const Tables::Side& side, hal::GrayImage& out) {
    resize(out, rig_.camera.width, rig_.camera.height);
    cv::Mat result = as_mat(out);
    cv::remap(as_mat(in), result, side.xy, side.fraction, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  };
  look_up(left, tables_->left, left_out);
  look_up(right, tables_->right, right_out);
}

}  // namespace headway::vision
