// How likely a match is one with the right thing, from how clearly it won and what it lies beside: the
// outlier weight beside sigma. A match with something else is off by any amount, which no wider Gaussian
// describes.
#pragma once

#include "vision/disparity.h"

namespace headway::vision {

/// weight = 1 - worst / (1 + exp((middle - a) / width)), where a is the match's ambiguity.
///
/// Beside a step or a pixel without a match (two pixels away in any of the eight directions) other values
/// hold: there one camera sees what the other does not, and blocks show two surfaces. Both curves are fitted
/// to the share of the census matcher's matches that are off by more than 2 px on Motorcycle: 0.3 % below
/// 0.1, 9 % at 0.55 and 41 % at 0.95 on one surface; 8 %, 26 % and 59 % beside a step or a gap.
struct WeightModel {
  struct Curve {
    double worst, middle, width;
  };
  Curve on_surface{0.5, 0.75, 0.12}, at_edge{0.65, 0.6, 0.15};
  double jump = 2;  ///< [px] disparity step that separates surfaces
};

/// Fills `disparity.weight` (NaN where there is no match); leaves it empty where the matcher tells no
/// ambiguity.
void estimate_weight(const WeightModel& model, DisparityImage& disparity);

}  // namespace headway::vision
