#include "vision/disparity_sigma.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace headway::vision {

namespace {

constexpr int kReach = 2;  // [px]

}  // namespace

void estimate_sigma(const SigmaModel& model, DisparityImage& disparity) {
  const int width = disparity.width, height = disparity.height;
  const auto base = static_cast<float>(model.base), jump = static_cast<float>(model.jump);
  const auto clear = static_cast<float>(model.clear), ambiguous = static_cast<float>(model.ambiguous);
  const auto base_at = [&](std::size_t i) {
    if (disparity.ambiguity.empty()) return base;
    return base * (clear + ambiguous * disparity.ambiguity[i] * disparity.ambiguity[i]);
  };
  disparity.sigma.assign(disparity.values.size(), DisparityImage::kNone);
  for (int v = 0; v < height; ++v) {
    const std::array<int, 3> rows{std::max(0, v - kReach), v, std::min(height - 1, v + kReach)};
    for (int u = 0; u < width; ++u) {
      const float d = disparity.values[disparity.index(u, v)];
      if (std::isnan(d)) continue;
      const std::array<int, 3> columns{std::max(0, u - kReach), u, std::min(width - 1, u + kReach)};
      float lowest = 0, highest = 0;  // relative to d
      for (const int row : rows)
        for (const int column : columns) {
          const float step = disparity.values[disparity.index(column, row)] - d;
          if (!(std::abs(step) <= jump)) continue;  // another surface, or no match
          lowest = std::min(lowest, step);
          highest = std::max(highest, step);
        }
      const float spread = highest - lowest;
      const float own = base_at(disparity.index(u, v));
      disparity.sigma[disparity.index(u, v)] = std::sqrt(own * own + spread * spread / 12);
    }
  }
}

}  // namespace headway::vision
