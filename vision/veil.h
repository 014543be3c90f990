// Veils: at the edge of a near thing a matcher smears disparities over to the background, a curtain in the
// air that no surface explains. It hangs along the line of sight, which is how it is told from a surface, and
// it is torn: there are pixels without a match in it or beside it.
#pragma once

#include "vision/disparity.h"
#include "vision/range_view.h"

namespace headway::vision {

struct VeilFilter {
  /// Steepest change of disparity over the image [px/px] that is still a surface. A wall that the line of
  /// sight passes at distance a changes by baseline / a: with 0.144 m, 0.5 is a wall 0.29 m beside the
  /// camera.
  double steepest = 0.5;
  double steepest_torn = 0.2;  ///< the same where pixels without a match are within reach
  int reach = 3;               ///< looks this far to both sides [px]; things no wider than this stay
};

/// Drops from `view` the points whose disparity lies on a slope too steep for a surface, along rows or
/// columns. Both have one size; `disparity` is not changed.
void drop_veils(const DisparityImage& disparity, const VeilFilter& filter, RangeView& view);

}  // namespace headway::vision
