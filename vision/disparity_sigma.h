// How far a match may be off: per pixel, from what the image and the disparities around it look like.
#pragma once

#include "hal/frame.h"
#include "vision/disparity.h"

namespace headway::vision {

/// sigma^2 = base^2 + (slope_share * disparity change per pixel)^2 + (noise / image gradient)^2   [px^2].
struct SigmaModel {
  double base = 0.3;  ///< [px] of a good match; StereoVision takes it from the rig
};

/// Fills `disparity.sigma` (NaN where there is no match). `left` is the image that was matched.
void estimate_sigma(const hal::GrayImage& left, const SigmaModel& model, DisparityImage& disparity);

}  // namespace headway::vision
