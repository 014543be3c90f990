// What a matcher finds: for each pixel of the left image, how far left its partner in the right image lies.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

namespace headway::vision {

/// Row-major, height x width. NaN is "no match"; zero and negative values are disparities like any other.
struct DisparityImage {
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  int width = 0, height = 0;
  std::vector<float> values;  ///< u_left - u_right [px]
  std::vector<float>
      sigma;  ///< standard deviation [px], same layout; empty as long as nobody has estimated it

  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
  }
  void resize(int w, int h) {
    width = w, height = h;
    values.assign(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), kNone);
    sigma.clear();
  }
};

}  // namespace headway::vision
