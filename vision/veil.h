// Veils: at the edge of a near thing a matcher smears disparities over to the background, a curtain in the
// air that no surface explains. It hangs along the line of sight, which is how it is told from a surface, and
// it is torn: there are pixels without a match in it or beside it, or the disparity bends as on no surface.
#pragma once

#include "vision/disparity.h"
#include "vision/range_view.h"

namespace headway::vision {

struct VeilFilter {
  /// Steepest change of disparity over the image [px/px] that is still a surface. A wall that the line of
  /// sight passes at distance a changes by baseline / a: with 0.144 m, 0.5 is a wall 0.29 m beside the
  /// camera.
  double steepest = 0.5;
  double steepest_torn = 0.2;  ///< the same where it is torn within reach
  /// Sigma [px] beyond which a match is as good as torn. Next to none on surfaces are so wide; they are where
  /// the matcher rounded a step off, of which small ones leave no pixel without a match.
  double widest_whole = 0.5;
  int reach = 3;  ///< looks this far to both sides [px]; things no wider than this stay
};

/// Drops from `view` the points whose disparity lies on a slope too steep for a surface, along rows or
/// columns. Both have one size; `disparity` is not changed. Without its sigma, what is torn is told from
/// missing pixels alone. The same bytes on every processor.
void drop_veils(const DisparityImage& disparity, const VeilFilter& filter, RangeView& view);

}  // namespace headway::vision
