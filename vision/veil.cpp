#include "vision/veil.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace headway::vision {

namespace {

/// A row or a column of the image: `length` values, `stride` apart, and their sigmas, or none.
struct Line {
  const float *values, *sigmas;
  int length;
  std::ptrdiff_t stride;
  float at(int i) const { return values[i * stride]; }
  bool known(int i) const { return !std::isnan(at(i)); }
  bool wider(int i, double sigma) const {
    return sigmas != nullptr && static_cast<double>(sigmas[i * stride]) > sigma;
  }
};

/// Whether pixel `i` of the line lies on a slope too steep for a surface.
bool steep(const Line& line, int i, const VeilFilter& filter) {
  const int first = std::max(0, i - filter.reach), last = std::min(line.length - 1, i + filter.reach);
  int low = i, high = i;
  bool torn = false;
  for (int j = first; j <= last; ++j) {
    torn = torn || !line.known(j) || line.wider(j, filter.widest_whole);
    if (line.known(j)) low = std::min(low, j), high = std::max(high, j);
  }
  const double rise = static_cast<double>(std::abs(line.at(high) - line.at(low)));
  return rise > (torn ? filter.steepest_torn : filter.steepest) * (high - low);
}

}  // namespace

void drop_veils(const DisparityImage& disparity, const VeilFilter& filter, RangeView& view) {
  const auto line = [&](int u, int v, int length, std::ptrdiff_t stride) -> Line {
    const std::size_t first = disparity.index(u, v);
    return {&disparity.values[first], disparity.sigma.empty() ? nullptr : &disparity.sigma[first], length,
            stride};
  };
  for (int v = 0; v < disparity.height; ++v)
    for (int u = 0; u < disparity.width; ++u) {
      if (std::isnan(disparity.values[disparity.index(u, v)])) continue;
      if (!steep(line(0, v, disparity.width, 1), u, filter) &&
          !steep(line(u, 0, disparity.height, disparity.width), v, filter))
        continue;
      const std::size_t i = view.index(u, v);
      view.depth[i] = view.sigma_depth[i] = DisparityImage::kNone;
      if (!view.weight.empty()) view.weight[i] = DisparityImage::kNone;
    }
}

}  // namespace headway::vision
