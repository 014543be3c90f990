#include "vision/veil.h"

#include <cmath>

namespace headway::vision {

void drop_veils(const DisparityImage& disparity, const VeilFilter& filter, RangeView& view) {
  const int w = disparity.width, h = disparity.height, r = filter.reach;
  const float most = static_cast<float>(filter.steepest * 2 * r);
  const auto steep = [&](int u0, int v0, int u1, int v1) {
    if (u0 < 0 || v0 < 0 || u1 >= w || v1 >= h) return false;
    // Not a number on either side compares false: what is not known condemns nothing.
    return std::abs(disparity.values[disparity.index(u1, v1)] - disparity.values[disparity.index(u0, v0)]) >
           most;
  };
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u)
      if (steep(u - r, v, u + r, v) || steep(u, v - r, u, v + r))
        view.depth[view.index(u, v)] = view.sigma_depth[view.index(u, v)] = DisparityImage::kNone;
}

}  // namespace headway::vision
