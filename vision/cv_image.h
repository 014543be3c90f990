// Plain images as OpenCV sees them: the same memory, no copy. For the .cpp files of this folder.
#pragma once

#include <opencv2/core.hpp>

#include "hal/frame.h"

namespace headway::vision {

/// OpenCV takes no const memory; it only reads what is passed as an input.
inline cv::Mat as_mat(const hal::GrayImage& image) {
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data())};
}

inline void resize(hal::GrayImage& image, int width, int height) {
  image.width = width, image.height = height;
  image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

/// False for an image whose memory does not hold what its size says.
inline bool complete(const hal::GrayImage& image) {
  return image.width > 0 && image.height > 0 &&
         image.pixels.size() ==
             static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

}  // namespace headway::vision
