// Plots of what a rig can see: sections through its field, resolution and angles over depth. All CV_8UC3.
#pragma once

#include <opencv2/core/mat.hpp>

#include "vision/characterise.h"

namespace headway::app {

/// Sections through the field from above and from the side: resolution by colour, and the outlines of the
/// polytopes for a resolution.
cv::Mat sections_picture(const vision::Characteristics& rig);

/// Resolution over depth: on the axis and in the worst corner as the formula has it, and as measured.
cv::Mat resolution_plot(const vision::Characteristics& rig);

/// Opening angles of the common view over depth, beside the paper's 33 x 33 deg.
cv::Mat angles_plot(const vision::RectifiedRig& rig);

}  // namespace headway::app
