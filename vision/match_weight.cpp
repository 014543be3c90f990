#include "vision/match_weight.h"

#include <array>
#include <cmath>

namespace headway::vision {

void estimate_weight(const WeightModel& model, DisparityImage& disparity) {
  disparity.weight.clear();
  if (disparity.ambiguity.empty()) return;
  // The function at steps of 1/256, each taken for its interval: an exponential per pixel would take longer
  // than the rest of what is done to it.
  constexpr int kSteps = 256;
  std::array<float, kSteps + 1> table{};
  for (int i = 0; i <= kSteps; ++i) {
    const double a = (i + 0.5) / kSteps;
    table[static_cast<std::size_t>(i)] =
        static_cast<float>(1 - model.worst / (1 + std::exp((model.middle - a) / model.width)));
  }
  disparity.weight.assign(disparity.values.size(), DisparityImage::kNone);
  for (std::size_t i = 0; i < disparity.weight.size(); ++i)
    if (!std::isnan(disparity.values[i]))
      disparity.weight[i] = table[static_cast<std::size_t>(disparity.ambiguity[i] * kSteps)];
}

}  // namespace headway::vision
