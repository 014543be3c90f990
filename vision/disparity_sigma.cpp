#include "vision/disparity_sigma.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace headway::vision {

namespace {

constexpr int kReach = 2;  // [px]
constexpr std::array<std::array<int, 2>, 4> kWays{{{1, 0}, {1, 1}, {0, 1}, {-1, 1}}};

/// How far the disparity at (u, v) lies off the mean of two opposite neighbours, at the most. Pairs that the
/// image's border, a step or a pixel without a match breaks tell nothing.
float bend(const DisparityImage& disparity, float jump, int u, int v) {
  const float d = disparity.values[disparity.index(u, v)];
  float most = 0;
  for (const auto& [x, y] : kWays) {
    const int du = kReach * x, dv = kReach * y;
    if (u < std::abs(du) || u + std::abs(du) >= disparity.width || v < dv || v + dv >= disparity.height)
      continue;
    const float after = disparity.values[disparity.index(u + du, v + dv)] - d;
    const float before = disparity.values[disparity.index(u - du, v - dv)] - d;
    if (std::abs(after) <= jump && std::abs(before) <= jump) most = std::max(most, std::abs(after + before));
  }
  return most / 2;
}

float together(float a, float b) { return std::sqrt(a * a + b * b); }

}  // namespace

void estimate_sigma(const SigmaModel& model, DisparityImage& disparity) {
  const auto base = static_cast<float>(model.base), jump = static_cast<float>(model.jump);
  const auto clear = static_cast<float>(model.clear), doubtful = static_cast<float>(model.doubtful);
  const auto base_at = [&](std::size_t i) {
    if (disparity.doubt.empty()) return base;
    return base * (clear + doubtful * disparity.doubt[i] * disparity.doubt[i]);
  };
  disparity.sigma.assign(disparity.values.size(), DisparityImage::kNone);
  for (int v = 0; v < disparity.height; ++v)
    for (int u = 0; u < disparity.width; ++u) {
      const std::size_t i = disparity.index(u, v);
      if (!std::isnan(disparity.values[i]))
        disparity.sigma[i] = together(base_at(i), bend(disparity, jump, u, v));
    }
}

}  // namespace headway::vision
