// What a calibration says about two cameras that look at the same space.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

namespace headway::vision {

/// One camera: pinhole with radial-tangential distortion (OpenCV's and EuRoC's model). Pixel centres lie at
/// whole numbers, (0, 0) is the centre of the upper left pixel.
struct CameraIntrinsics {
  int width = 0, height = 0;              ///< [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  bool distorts() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0; }
  /// The pixel that a point in the camera's optical frame [m] falls on, with distortion. Needs z > 0.
  Eigen::Vector2d project(const Eigen::Vector3d& point) const;
};

/// Two calibrated cameras. `right_from_left` maps points of the left optical frame to the right one [m].
struct StereoRig {
  std::string name;
  CameraIntrinsics left, right;
  Eigen::Isometry3d right_from_left = Eigen::Isometry3d::Identity();
  double nearest = 0.8;           ///< depth Z [m] that must still be matched: sets the disparity range
  double farthest = 6.0;          ///< depth Z [m] up to which points go into the map
  double disparity_sigma = 0.25;  ///< standard deviation [px] of a match on a surface of constant depth

  double baseline() const { return right_from_left.translation().norm(); }  ///< [m]
};

/// What is wrong with a rig, and with which key of a rig file it has to do.
struct RigFault {
  std::string key, what;
};

/// Nothing for a usable rig: positive focal lengths, principal points inside the images, sizes that agree,
/// 0.02 m < baseline < 1 m, the right camera on the right, views that overlap, 0 < nearest < farthest.
std::optional<RigFault> fault_of(const StereoRig& rig);

/// Throws InputError `NAME: key: what` for an unusable rig.
void require_usable(const StereoRig& rig);

}  // namespace headway::vision
