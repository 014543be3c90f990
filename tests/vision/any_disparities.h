// Disparity images of any content and size, from wholly known to mostly torn.
#pragma once

#include <cstdint>
#include <random>

#include "vision/disparity.h"

namespace headway::vision {

/// Up to 40 x 12 px; disparities of 1/16 px, one in six missing; ambiguity like it.
inline DisparityImage any_disparities(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  DisparityImage image;
  image.resize(1 + static_cast<int>(random() % 40), 1 + static_cast<int>(random() % 12));
  image.ambiguity = image.values;
  for (std::size_t i = 0; i < image.values.size(); ++i)
    if (random() % 6 != 0) {
      image.values[i] = static_cast<float>(random() % 64) / 16;
      image.ambiguity[i] = static_cast<float>(random() % 1000) / 1000;
    }
  return image;
}

}  // namespace headway::vision
