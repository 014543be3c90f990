#include "vision/match_weight.h"

#include <algorithm>

namespace headway::vision {

void estimate_weight(const WeightModel& model, DisparityImage& disparity) {
  disparity.weight.resize(disparity.doubt.size());
  const auto worst = static_cast<float>(model.worst);
  std::transform(disparity.doubt.begin(), disparity.doubt.end(), disparity.weight.begin(),
                 [&](float doubt) { return 1 - worst * doubt * doubt * doubt; });
}

}  // namespace headway::vision
