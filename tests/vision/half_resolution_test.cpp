// Half the resolution, as the frame loop falls back on: points are as much less sure as the covariance says.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "tests/true_pairs/true_pairs.h"
#include "vision/stereo.h"

namespace headway::vision {
namespace {

/// As a camera of 60 degrees with a baseline of 0.1 m would have taken it.
StereoRig rig_of(const TruePair& pair) {
  StereoRig rig;
  rig.name = pair.name;
  CameraIntrinsics& left = rig.left;
  left.width = pair.left.width, left.height = pair.left.height;
  left.fx = left.fy = 0.87 * left.width;
  left.cx = 0.5 * (left.width - 1), left.cy = 0.5 * (left.height - 1);
  rig.right = left;
  rig.right_from_left.translation().x() = -0.1;
  rig.nearest = left.fx * 0.1 / (pair.disparities - 1);
  rig.farthest = left.fx * 0.1 / 2;
  return rig;
}

/// The true disparity [px] at a place in the whole image; NaN where it is not known or jumps.
float truth_at(const DisparityImage& truth, const Eigen::Vector2d& pixel) {
  const int u = static_cast<int>(std::floor(pixel.x())), v = static_cast<int>(std::floor(pixel.y()));
  if (u < 0 || v < 0 || u + 1 >= truth.width || v + 1 >= truth.height) return DisparityImage::kNone;
  float sum = 0, low = 1e9F, high = 0;
  for (const int dv : {0, 1})
    for (const int du : {0, 1}) {
      const float d = truth.values[truth.index(u + du, v + dv)];
      if (std::isnan(d)) return DisparityImage::kNone;
      sum += d;
      low = std::min(low, d), high = std::max(high, d);
    }
  return high - low < 1 ? sum / 4 : DisparityImage::kNone;
}

struct Quality {
  double coverage = 0;      ///< within 3 sigma of the truth, by weight
  double density = 0;       ///< of the pixels whose truth is known
  double median_sigma = 0;  ///< sigma_Z / Z^2 [1/m]
};

Quality quality(const TruePair& pair, double scale) {
  VisionConfig config;
  config.scale = scale;
  const StereoRig rig = rig_of(pair);
  StereoVision vision(rig, config);
  hal::StereoFrame frame;
  frame.left = pair.left, frame.right = pair.right;
  const RangeView& view = vision.see(frame);
  EXPECT_EQ(vision.fault(), "");
  double known = 0, found = 0, weight = 0, within = 0;
  std::vector<double> sigmas;
  for (int v = 0; v < view.camera.height; ++v)
    for (int u = 0; u < view.camera.width; ++u) {
      const float d = truth_at(pair.truth, rig.left.project(view.camera.point(u, v, 1)));
      if (std::isnan(d)) continue;
      ++known;
      const auto at = view.index(u, v);
      if (std::isnan(view.depth[at])) continue;
      ++found;
      const double truth = rig.left.fx * 0.1 / static_cast<double>(d),
                   z = static_cast<double>(view.depth[at]);
      const double w = view.weight.empty() ? 1 : static_cast<double>(view.weight[at]);
      const double sigma = static_cast<double>(view.sigma_depth[at]);
      weight += w;
      if (std::abs(z - truth) <= 3 * sigma) within += w;
      sigmas.push_back(sigma / (z * z));
    }
  std::nth_element(sigmas.begin(), sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2),
                   sigmas.end());
  return {within / weight, found / known, sigmas[sigmas.size() / 2]};
}

TEST(HalfResolutionSlow, LiesWithinThreeSigmaOfTheTruthAsTheWholeDoes) {
  for (const TruePair& pair : held_out_pairs()) {
    SCOPED_TRACE(pair.name);
    const Quality whole = quality(pair, 1), half = quality(pair, 0.5);
    std::printf("%-24s within 3 sigma %.3f, half %.3f; density %.2f, half %.2f; sigma x %.2f\n",
                pair.name.c_str(), whole.coverage, half.coverage, whole.density, half.density,
                half.median_sigma / whole.median_sigma);
    EXPECT_GE(half.coverage, 0.97);
    EXPECT_GT(half.density, 0.8 * whole.density);
    // Half as precise; less so where the mean of four pixels takes noise away.
    EXPECT_GT(half.median_sigma / whole.median_sigma, 1.2);
    EXPECT_LT(half.median_sigma / whole.median_sigma, 2.2);
  }
}

}  // namespace
}  // namespace headway::vision
