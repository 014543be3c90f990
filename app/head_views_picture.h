// Where the head looked during its calibration, and how well each view fits.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "hal/head.h"

namespace headway::app {

struct HeadViewMark {
  hal::HeadAngles angles;  ///< as reported [rad]
  double error = 0;        ///< rms distance of the corners [px]
  bool stands_out = false;
};

/// Pan to the left, tilt upwards, as the robot sees it; views coloured by error, those that stand out ringed.
cv::Mat head_views_picture(const std::vector<HeadViewMark>& views);

}  // namespace headway::app
