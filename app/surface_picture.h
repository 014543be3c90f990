// What one look reconstructed, as a surface in space, with or without the uncertainty of its points.
#pragma once

#include <opencv2/core/mat.hpp>

#include "hal/frame.h"
#include "vision/range_view.h"

namespace headway::app {

/// The paper's figure 3: twice the surface through the points of `view`, in the grey values of the rectified
/// left image, seen from beside the camera; on the right with ellipsoids of ten standard deviations on a
/// lattice of points, coloured by resolution. CV_8UC3.
cv::Mat surface_picture(const vision::RangeView& view, const hal::GrayImage& left);

}  // namespace headway::app
