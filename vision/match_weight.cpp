#include "vision/match_weight.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace headway::vision {

namespace {

constexpr int kReach = 2;  // [px]

/// The function at steps of 1/256, each taken for its interval: an exponential per pixel would take longer
/// than the rest of what is done to it.
constexpr int kSteps = 256;
using Table = std::array<float, kSteps + 1>;

Table table_of(const WeightModel::Curve& c) {
  Table table{};
  for (int i = 0; i <= kSteps; ++i) {
    const double a = (i + 0.5) / kSteps;
    table[static_cast<std::size_t>(i)] =
        static_cast<float>(1 - c.worst / (1 + std::exp((c.middle - a) / c.width)));
  }
  return table;
}

/// Whether a step or a pixel without a match lies beside (u, v).
bool at_edge(const DisparityImage& disparity, float jump, int u, int v) {
  const float d = disparity.values[disparity.index(u, v)];
  const std::array<int, 3> columns{std::max(0, u - kReach), u, std::min(disparity.width - 1, u + kReach)};
  for (const int row : {std::max(0, v - kReach), v, std::min(disparity.height - 1, v + kReach)})
    for (const int column : columns)
      if (!(std::abs(disparity.values[disparity.index(column, row)] - d) <= jump)) return true;
  return false;
}

}  // namespace

void estimate_weight(const WeightModel& model, DisparityImage& disparity) {
  disparity.weight.clear();
  if (disparity.ambiguity.empty()) return;
  const Table on_surface = table_of(model.on_surface), beside = table_of(model.at_edge);
  const auto jump = static_cast<float>(model.jump);
  disparity.weight.assign(disparity.values.size(), DisparityImage::kNone);
  for (int v = 0; v < disparity.height; ++v)
    for (int u = 0; u < disparity.width; ++u) {
      const std::size_t i = disparity.index(u, v);
      if (std::isnan(disparity.values[i])) continue;
      const Table& table = at_edge(disparity, jump, u, v) ? beside : on_surface;
      disparity.weight[i] = table[static_cast<std::size_t>(disparity.ambiguity[i] * kSteps)];
    }
}

}  // namespace headway::vision
