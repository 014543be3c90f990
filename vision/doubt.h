// How doubtful a match is: how clearly it won, and how clearly what lies around it did and agrees with it.
#pragma once

#include "vision/disparity.h"

namespace headway::vision {

/// doubt = mean over the match and its eight neighbours (two pixels away) of their ambiguity, or 1 for one
/// without a match or on another surface.
///
/// Why: one match may win clearly by chance, nine do not; and beside a step or a gap one camera sees what the
/// other does not, and blocks show two surfaces. It tells gross errors from right matches, and the noise of
/// the latter, better than the match's own ambiguity: on Motorcycle, aloe and Tsukuba a wrong match is the
/// more doubtful of the two in 90, 96 and 90 % of cases, and the more ambiguous in 87, 93 and 86 %.
struct DoubtModel {
  double jump = 2;  ///< [px] disparity step that separates surfaces
};

/// Fills `disparity.doubt` (NaN where there is no match); leaves it empty where the matcher tells no
/// ambiguity. Beyond the image's border its outermost pixels go on. The same bytes on every processor.
void estimate_doubt(const DoubtModel& model, DisparityImage& disparity);

}  // namespace headway::vision
