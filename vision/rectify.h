// Turns the two raw images into those of two ideal cameras side by side, so that partners lie in the same
// row.
#pragma once

#include <Eigen/Geometry>
#include <memory>

#include "hal/frame.h"
#include "hal/two_processors.h"
#include "vision/rectified_rig.h"
#include "vision/rig.h"

namespace headway::vision {

/// Pixel tables are made once; rectifying is one bilinear look-up per pixel. The rectified images show only
/// what both lenses saw entirely (no black borders), at most 63 deg off the axis, and have square pixels.
/// Images that are rectified already (no distortion, no rotation, one focal length) are passed on untouched,
/// so nothing is lost by resampling.
class Rectifier {
 public:
  /// `scale` shrinks the rectified images (0.5: half the width and height). Throws InputError for an unusable
  /// rig.
  explicit Rectifier(const StereoRig& rig, double scale = 1);

  const StereoRig& raw() const { return raw_; }
  const RectifiedRig& rig() const { return rig_; }
  const PinholeCamera& camera() const { return rig_.camera; }
  double baseline() const { return rig_.baseline; }  ///< [m]
  /// Maps points of the raw left optical frame to the rectified one: a pure rotation.
  const Eigen::Isometry3d& rectified_from_left() const { return rectified_from_left_; }
  const Eigen::Isometry3d& rectified_from_right() const {
    return rectified_from_right_;
  }  ///< the same, right
  bool passes_through() const { return tables_ == nullptr; }

  /// The rectified pixel that a raw pixel of the left or right image comes to lie on; NaN where its ray (see
  /// CameraIntrinsics::unproject) leads nowhere on the rectified plane.
  Eigen::Vector2d rectified_left(const Eigen::Vector2d& raw) const;
  Eigen::Vector2d rectified_right(const Eigen::Vector2d& raw) const;

  /// True when both images have the size that the rig says.
  bool accepts(const hal::GrayImage& left, const hal::GrayImage& right) const;
  /// Writes both rectified images. Call only with images that it accepts.
  void rectify(const hal::GrayImage& left, const hal::GrayImage& right, hal::GrayImage& left_out,
               hal::GrayImage& right_out, hal::TwoProcessors& processors = hal::one_processor()) const;

 private:
  struct Tables;
  Eigen::Vector2d rectified(const CameraIntrinsics& camera, const Eigen::Isometry3d& turn,
                            const Eigen::Vector2d& raw) const;

  StereoRig raw_;
  RectifiedRig rig_;
  Eigen::Isometry3d rectified_from_left_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d rectified_from_right_ = Eigen::Isometry3d::Identity();
  std::shared_ptr<const Tables> tables_;  // never written after construction, so copies may share it
};

}  // namespace headway::vision
