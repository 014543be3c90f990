// A rig after rectification: one pinhole camera and a baseline say everything.
#pragma once

#include <cmath>

#include "vision/range_view.h"

namespace headway::vision {

/// Both rectified images are those of `camera`; a point at depth Z appears `disparity` pixels further left in
/// the right image: u_right = u_left - d, Z = focal * baseline / (d + disparity_offset).
struct RectifiedRig {
  PinholeCamera camera;
  double baseline = 0;          ///< [m]
  double disparity_offset = 0;  ///< cx_right - cx_left [px]; zero unless the images came rectified that way
  double nearest = 0, farthest = 0;  ///< depths Z [m], as in StereoRig
  double disparity_sigma = 0.25;     ///< [px], at this camera's resolution

  double depth(double disparity) const { return camera.focal * baseline / (disparity + disparity_offset); }
  double disparity(double depth_z) const { return camera.focal * baseline / depth_z - disparity_offset; }
};

/// Whole disparities to search: lowest, lowest + 1, ..., lowest + count - 1.
struct DisparityRange {
  int lowest = 0, count = 64;
};

/// From infinity to the nearest distance; `count` is a multiple of 16, as the matcher wants it.
inline DisparityRange disparity_range(const RectifiedRig& rig) {
  const int lowest = static_cast<int>(std::floor(-rig.disparity_offset));
  const int highest = static_cast<int>(std::ceil(rig.disparity(rig.nearest)));
  return {lowest, (highest - lowest + 1 + 15) / 16 * 16};
}

}  // namespace headway::vision
