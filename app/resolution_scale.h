// Resolutions as colours, and the bar that explains them.
#pragma once

#include <vector>

#include "app/drawing.h"
#include "vision/characterise.h"

namespace headway::app {

/// Colours of resolutions [m] on a logarithmic scale; the ramp's brightest end is left out, it fades on
/// paper.
class ResolutionScale {
 public:
  ResolutionScale(double lowest, double highest);
  /// From the finest on the axis to the worst in a corner.
  explicit ResolutionScale(const vision::Characteristics& rig);

  Colour colour(double resolution) const;
  /// Pictures side by side, and at their right the scale with its marks.
  cv::Mat beside(std::vector<cv::Mat> pictures) const;

 private:
  cv::Mat bar(int height) const;

  double lowest_, highest_;
};

}  // namespace headway::app
