// What a tour of the head shows of all directions around it. CV_8UC3.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "hal/head_kinematics.h"
#include "vision/polytope.h"

namespace headway::app {

/// A head that looks in some directions, and how that is named below the picture.
struct Tour {
  std::vector<hal::HeadAngles> views;
  double distance = 0;  ///< of what is looked at [m]
  std::string caption;
};
/// Directions around the neck: how many views show each, and what the head could show but these views do not.
/// `field` has no depth limits and is in the frame that `neck` leads to.
cv::Mat tours_picture(const vision::Polytope& field, const hal::HeadKinematics& neck,
                      const hal::HeadLimits& limits, const std::vector<Tour>& tours);

}  // namespace headway::app
