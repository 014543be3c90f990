// How good a disparity image is, against the truth.
#pragma once

#include <cstddef>

#include "vision/disparity.h"

namespace headway::vision {

/// Counted over pixels whose truth is known. Shares are 0..1; those of matched pixels are 0 when none is
/// matched.
struct MatchQuality {
  std::size_t known = 0, matched = 0;
  double density = 0;           ///< matched / known
  double bad_1 = 0, bad_2 = 0;  ///< share of the matched that is off by more than 1 / 2 px
  double inlier_rms = 0;        ///< rms error [px] of those off by at most 2 px
  /// Share of the matched within 3 sigma of the truth, and the median sigma [px]; of points that have a
  /// sigma.
  double coverage_3_sigma = 0, median_sigma = 0;
};

/// Compares images of one size; throws InputError for others.
MatchQuality compare(const DisparityImage& found, const DisparityImage& truth);

}  // namespace headway::vision
