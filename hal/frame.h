// What a camera delivers: plain images with the time of their exposure.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/time.h"

namespace headway::hal {

/// 8-bit grey values, row-major, height x width, no padding.
struct GrayImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

/// Two images exposed at the same moment, as the sensors saw them (not rectified).
struct StereoFrame {
  Time exposure{};             ///< middle of the exposure
  std::uint64_t sequence = 0;  ///< counts the camera's frames; a gap is a lost frame
  GrayImage left, right;
};

/// Distance along the optical axis for each pixel of the (rectified) left camera.
struct DepthFrame {
  Time exposure{};
  std::uint64_t sequence = 0;
  int width = 0, height = 0;
  std::vector<float> depth;  ///< Z [m], row-major; NaN where nothing was measured
};

}  // namespace headway::hal
