// The field of a rig: which points both cameras show, from its two image pyramids and its depth range.
#pragma once

#include <limits>

#include "vision/polytope.h"
#include "vision/rectified_rig.h"
#include "vision/rig.h"

namespace headway::vision {

/// What cuts a field off beside the images' edges.
struct FieldLimits {
  double near = 0;                                       ///< depth Z [m]; 0: from the cameras on
  double far = std::numeric_limits<double>::infinity();  ///< depth Z [m]
  /// Columns at the left of the left image that a matcher never fills; for OpenCV's without padding that is
  /// lowest + count of its disparities. Our matchers fill all columns whose partners lie inside.
  int blind_columns = 0;
};

/// The depths between which a search of these disparities finds points: Z = f B / (d + offset). `far` is
/// infinite when it goes down to zero parallax.
FieldLimits depth_limits(const RectifiedRig& rig, const DisparityRange& range);

/// The minimal polytope of a rectified rig, in the left camera's optical frame: 4 half-spaces, 5 with a near
/// limit, 6 with both (8 corners). Images end half a pixel beyond their outermost pixel centres. Throws
/// InputError when the baseline is not positive, or when no point lies in both images.
Polytope rig_polytope(const RectifiedRig& rig, const FieldLimits& limits);

/// The same of two cameras as they are mounted, in the left one's optical frame: in general 8, 9 and 10
/// half-spaces (16 corners). Lenses are taken as ideal (their distortion left out), and depth counts along
/// `depth_axis(rig)`. Throws InputError for an unusable rig as well (rig.h).
Polytope rig_polytope(const StereoRig& rig, const FieldLimits& limits);

/// The mean of both optical axes made perpendicular to the baseline, in the left optical frame; unit length.
Eigen::Vector3d depth_axis(const StereoRig& rig);

/// Pixels from points in the left optical frame [m], for an ideal lens.
Eigen::Matrix<double, 3, 4> left_projection(const StereoRig& rig);
Eigen::Matrix<double, 3, 4> right_projection(const StereoRig& rig);

}  // namespace headway::vision
