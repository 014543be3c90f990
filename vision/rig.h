// What a calibration says about two cameras that look at the same space.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "vision/camera_intrinsics.h"

namespace headway::vision {

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

/// Nothing for a usable rig: images of up to 33 megapixels, positive focal lengths, principal points inside
/// the images, lenses that keep every pixel apart (equidistant ones: up to the middles of the image's edges),
/// sizes that agree, 0.02 m < baseline < 1 m, the right camera on the right (its place at most 25 deg off the
/// left camera's x axis), cameras turned apart by no more than half the narrower field, views that share a
/// tenth of one image somewhere between nearest and farthest, 0 < nearest < farthest.
std::optional<RigFault> fault_of(const StereoRig& rig);

/// Throws InputError `NAME: key: what` for an unusable rig.
void require_usable(const StereoRig& rig);

}  // namespace headway::vision
