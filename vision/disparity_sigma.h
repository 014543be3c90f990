// How far a match may be off: per pixel, from how much the disparities around it vary and how clearly it won.
#pragma once

#include "vision/disparity.h"

namespace headway::vision {

/// sigma^2 = (base (clear + ambiguous a^2))^2 + spread^2 / 12   [px^2], where a is the match's ambiguity and
/// spread is the range of the disparities around the pixel (two pixels away in all eight directions), as far
/// as they belong to its surface. Of matchers that tell no ambiguity, sigma^2 = base^2 + spread^2 / 12.
///
/// Why: semi-global matching compares blocks and smooths along rows and columns, so on a slanted or curved
/// surface a pixel may be given the disparity of any place in its neighbourhood: uniform in the spread, hence
/// the twelve. The image gradient, which rules the error of plain block matching, does not predict it.
/// Neighbours beyond `jump` belong to another surface: a match that went to the wrong one of them is a gross
/// error, which no Gaussian describes; its sigma is not widened.
struct SigmaModel {
  double base = 0.25;  ///< [px] on a surface of constant depth; StereoVision takes it from the rig
  /// How base grows with ambiguity: fitted to the census matcher's errors on Motorcycle, which go from 0.16
  /// px for clear winners to 0.7 px for those that barely won.
  double clear = 0.7, ambiguous = 2.6;
  double jump = 2;  ///< [px] disparity step that separates surfaces
};

/// Fills `disparity.sigma` (NaN where there is no match).
void estimate_sigma(const SigmaModel& model, DisparityImage& disparity);

}  // namespace headway::vision
