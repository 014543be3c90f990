#include "vision/disparity_sigma.h"

#include <cmath>

namespace headway::vision {

void estimate_sigma(const hal::GrayImage& left, const SigmaModel& model, DisparityImage& disparity) {
  (void)left;
  disparity.sigma.assign(disparity.values.size(), DisparityImage::kNone);
  for (std::size_t i = 0; i < disparity.values.size(); ++i)
    if (!std::isnan(disparity.values[i])) disparity.sigma[i] = static_cast<float>(model.base);
}

}  // namespace headway::vision
