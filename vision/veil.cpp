#include "vision/veil.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace headway::vision {

namespace {

/// A row or a column of the image: `length` values, `stride` apart.
struct Line {
  const float* values;
  int length;
  std::ptrdiff_t stride;
  float at(int i) const { return values[i * stride]; }
};

/// Whether pixel `i` of the line lies on a slope too steep for a surface.
bool steep(const Line& line, int i, const VeilFilter& filter) {
  const int first = std::max(0, i - filter.reach), last = std::min(line.length - 1, i + filter.reach);
  int low = i, high = i;
  bool torn = false;
  for (int j = first; j <= last; ++j) {
    if (std::isnan(line.at(j)))
      torn = true;
    else
      low = std::min(low, j), high = std::max(high, j);
  }
  const double rise = static_cast<double>(std::abs(line.at(high) - line.at(low)));
  return rise > (torn ? filter.steepest_torn : filter.steepest) * (high - low);
}

}  // namespace

void drop_veils(const DisparityImage& disparity, const VeilFilter& filter, RangeView& view) {
  for (int v = 0; v < disparity.height; ++v)
    for (int u = 0; u < disparity.width; ++u) {
      if (std::isnan(disparity.values[disparity.index(u, v)])) continue;
      const Line row{&disparity.values[disparity.index(0, v)], disparity.width, 1};
      const Line column{&disparity.values[disparity.index(u, 0)], disparity.height, disparity.width};
      if (!steep(row, u, filter) && !steep(column, v, filter)) continue;
      const std::size_t i = view.index(u, v);
      view.depth[i] = view.sigma_depth[i] = DisparityImage::kNone;
      if (!view.weight.empty()) view.weight[i] = DisparityImage::kNone;
    }
}

}  // namespace headway::vision
