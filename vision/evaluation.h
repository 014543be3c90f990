// How good a disparity image is, against the truth.
#pragma once

#include <cstddef>

#include "vision/disparity.h"

namespace headway::vision {

/// Counted over pixels whose truth is known and whose partner lies inside the right image (the rig's field:
/// no matcher can find the others). Shares are 0..1; those of matched pixels are 0 when none is matched.
struct MatchQuality {
  std::size_t known = 0, matched = 0;
  double density = 0;           ///< matched / known
  double density_of_all = 0;    ///< matched / all pixels with truth, those outside the right image too
  double bad_1 = 0, bad_2 = 0;  ///< share of the matched that is off by more than 1 / 2 px
  /// Share of the known that is off by more than 2 px or not matched.
  double wrong_or_missing() const { return 1 - density * (1 - bad_2); }
  double inlier_rms = 0;  ///< rms error [px] of those off by at most 2 px
  /// Share of the matched (with a sigma) within 3 sigma of the truth, each counted with its weight.
  double coverage_3_sigma = 0;
  /// Area under the curve of right against wrong matches, as the bar of weight is raised: how often, of a
  /// match off by more than 2 px and one that is not, the former has less weight. 0 without weights.
  double weight_auc = 0;
  double inlier_coverage =
      0;  ///< the same, of those off by at most 2 px: what the Gaussian is meant to describe
  double inlier_z_rms = 0;  ///< rms of error / sigma of those: 1 when sigma is right
  double sigma_p10 = 0, sigma_median = 0, sigma_p90 = 0;  ///< percentiles of sigma [px]
  // Where the points outside 3 sigma lie; the three shares add up to 1.
  double outside_hidden = 0;  ///< the right camera sees something nearer there: whatever was matched is wrong
  double outside_at_edge = 0;  ///< within 3 px of a step of more than 2 px in the truth
  double outside_elsewhere = 0;
};

/// Compares images of one size; throws InputError for others.
MatchQuality compare(const DisparityImage& found, const DisparityImage& truth);

}  // namespace headway::vision
