// How far a match may be off: per pixel, from how much the surface around it bends and how doubtful it is.
#pragma once

#include "vision/disparity.h"

namespace headway::vision {

/// sigma^2 = (base (clear + doubtful d^2))^2 + bend^2   [px^2], where d is the match's doubt and bend is
/// how far its disparity lies off the mean of two opposite neighbours (two pixels away, the largest of the
/// four directions), as far as they belong to its surface. Where nobody has estimated the doubt,
/// sigma^2 = base^2 + bend^2.
///
/// Why: on a plane, slanted or not, semi-global matching is as good as facing it: opposite neighbours err to
/// both sides. What bends was flattened by the smoothing, or is the matcher's own noise, and the bend has the
/// size of either: the errors on Motorcycle, aloe and Tsukuba grow with it steadily, and not with the slope.
/// The image gradient, which rules the error of plain block matching, does not predict them.
/// Neighbours beyond `jump` belong to another surface: a match that went to the wrong one of them is a gross
/// error, which no Gaussian describes; its sigma is not widened.
struct SigmaModel {
  double base = 0.25;  ///< [px] on a surface of constant depth; StereoVision takes it from the rig
  /// How base grows with doubt: fitted to the census matcher's errors on Motorcycle, which go from 0.16 px
  /// where there is none to 0.9 px.
  double clear = 0.7, doubtful = 2.6;
  double jump = 2;  ///< [px] disparity step that separates surfaces
};

/// Fills `disparity.sigma` (NaN where there is no match), from `disparity.doubt` where there is one. The
/// same bytes on every processor.
void estimate_sigma(const SigmaModel& model, DisparityImage& disparity);

}  // namespace headway::vision
