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
  // Same layout; each is empty as long as nobody has estimated it, and NaN where there is no match.
  std::vector<float> ambiguity;  ///< cost of the match over that of its best rival, and more where other
                                 ///< things speak against it: 0 clear, 1 as good as lost
  std::vector<float> doubt;  ///< the same, of the match and of what lies around it: 0 none, 1 as good as lost
  std::vector<float> sigma;  ///< standard deviation [px] of a match with the right thing
  std::vector<float> weight;  ///< probability, 0..1, that it is one with the right thing

  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
  }
  void resize(int w, int h) {
    width = w, height = h;
    values.assign(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), kNone);
    ambiguity.clear(), doubt.clear(), sigma.clear(), weight.clear();
  }
};

}  // namespace headway::vision
