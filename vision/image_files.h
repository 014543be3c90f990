// Images from files, checked: a missing, broken or huge file ends in one clear message.
#pragma once

#include <filesystem>

#include "hal/frame.h"
#include "vision/disparity.h"

namespace headway::vision {

/// An 8-bit grey image; colour is converted. All throw InputError `file: what, expected what`.
hal::GrayImage read_gray(const std::filesystem::path& file);

/// A 16-bit single-channel image of disparities times `per_pixel` (Middlebury, KITTI: 256); 0 is unknown.
DisparityImage read_disparity(const std::filesystem::path& file, double per_pixel = 256);

/// A 16-bit single-channel image of depths, `per_metre` units to the metre; 0 (and 65535) is nothing
/// measured.
hal::DepthFrame read_depth(const std::filesystem::path& file, double per_metre = 1000);

}  // namespace headway::vision
