// The sensor behind the lens.
#pragma once

namespace headway::sim {

/// What the sensor and the lens add to the light.
struct Imager {
  double noise_sigma = 1.5;  ///< of each pixel, grey levels
  double vignetting = 0.15;  ///< share of light lost in the corners
  double exposure = 1.2;     ///< gain
};

}  // namespace headway::sim
