#include "vision/evaluation.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "vision/disparity_sigma.h"
#include "vision/match_weight.h"

namespace headway::vision {
namespace {

DisparityImage flat(int width, int height, float d) {
  DisparityImage image;
  image.resize(width, height);
  for (float& value : image.values) value = d;
  return image;
}

TEST(Compare, CountsByHand) {
  DisparityImage truth = flat(10, 1, 1);
  truth.values[9] = DisparityImage::kNone;  // not known: does not count
  // Pixel 0 has its partner outside the right image: no matcher can find it.
  DisparityImage found = truth;
  found.values = {5, 1, 1.5F, 2.5F, 4, DisparityImage::kNone, 1, 1, 1, 99};
  found.sigma.assign(10, 0.5F);
  const MatchQuality q = compare(found, truth);
  EXPECT_EQ(q.known, 8U);
  EXPECT_EQ(q.matched, 7U);
  EXPECT_DOUBLE_EQ(q.density, 7 / 8.0);
  EXPECT_DOUBLE_EQ(q.density_of_all, 7 / 9.0);
  EXPECT_DOUBLE_EQ(q.bad_1, 2 / 7.0);
  EXPECT_DOUBLE_EQ(q.bad_2, 1 / 7.0);
  EXPECT_DOUBLE_EQ(q.coverage_3_sigma, 6 / 7.0) << "3 px off is outside 1.5 px, 1.5 px is on it";
  EXPECT_DOUBLE_EQ(q.inlier_rms, std::sqrt((0.25 + 2.25) / 6));
  EXPECT_DOUBLE_EQ(q.sigma_median, 0.5);
  EXPECT_DOUBLE_EQ(q.outside_elsewhere, 1);
}

TEST(Compare, TellsHiddenPointsFromEdges) {
  // A near strip (d = 8) before a wall (d = 2), seen by the left camera: columns 20..29. The right camera
  // does not see the wall in the six columns left of the strip.
  DisparityImage truth = flat(60, 1, 2);
  for (int u = 20; u < 30; ++u) truth.values[truth.index(u, 0)] = 8;
  DisparityImage found = truth;
  found.sigma.assign(60, 0.3F);
  found.values[16] = 8;  // hidden
  found.values[31] = 8;  // visible, beside the edge
  found.values[50] = 8;  // visible, far from it
  const MatchQuality q = compare(found, truth);
  EXPECT_DOUBLE_EQ(q.outside_hidden, 1 / 3.0);
  EXPECT_DOUBLE_EQ(q.outside_at_edge, 1 / 3.0);
  EXPECT_DOUBLE_EQ(q.outside_elsewhere, 1 / 3.0);
}

TEST(Compare, CountsHowOftenAWrongMatchHasLessWeight) {
  const DisparityImage truth = flat(10, 1, 1);
  DisparityImage found = truth;
  found.values = {9, 4, 4, 1, 1, 1, 1, 1, 1, 1};  // pixels 1 and 2 are wrong
  found.weight = {0, 0.5F, 0.9F, 0.9F, 0.2F, 1, 1, 1, 1, 1};
  // The first has less than six of the seven right ones, the second less than five and as much as one.
  EXPECT_DOUBLE_EQ(compare(found, truth).weight_auc, 11.5 / 14);
}

TEST(Compare, SurvivesNothingToCompare) {
  EXPECT_EQ(compare(flat(5, 5, DisparityImage::kNone), flat(5, 5, 1)).density, 0);
  EXPECT_EQ(compare(flat(5, 5, 1), flat(5, 5, DisparityImage::kNone)).known, 0U);
  EXPECT_EQ(compare({}, {}).known, 0U);
  EXPECT_THROW(compare(flat(5, 5, 1), flat(5, 4, 1)), InputError);
}

TEST(Sigma, IsTheBaseOnAPlaneAndGrowsWithItsBend) {
  DisparityImage image = flat(20, 20, 10);
  const auto bend = [&](float slope, float curvature) {
    for (int v = 0; v < 20; ++v)
      for (int u = 0; u < 20; ++u) {
        const auto x = static_cast<float>(u - 10);
        image.values[image.index(u, v)] = 10 + slope * x + curvature * x * x;
      }
    estimate_sigma({0.2, 1, 0}, image);
    return image.sigma[image.index(10, 10)];
  };
  EXPECT_FLOAT_EQ(bend(0, 0), 0.2F);
  EXPECT_NEAR(bend(0.25F, 0), 0.2F, 1e-5F);
  // Two pixels to each side: the mean of the two lies 0.4 px off.
  EXPECT_NEAR(bend(0.25F, 0.1F), std::sqrt(0.04F + 0.16F), 1e-5F);
}

TEST(Sigma, IsNotWidenedByAnotherSurfaceOrByGaps) {
  DisparityImage image = flat(20, 20, 10);
  for (int v = 0; v < 20; ++v)
    for (int u = 10; u < 20; ++u) image.values[image.index(u, v)] = 30;
  image.values[image.index(9, 5)] = DisparityImage::kNone;
  estimate_sigma({0.2, 2}, image);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    EXPECT_EQ(std::isnan(image.sigma[i]), std::isnan(image.values[i]));
    if (std::isnan(image.values[i])) continue;
    EXPECT_FLOAT_EQ(image.sigma[i], 0.2F);
  }
}

RC_GTEST_PROP(Sigma, IsNeverBelowTheBaseNorAboveTheJump, (std::uint64_t seed)) {
  std::mt19937_64 random(seed);
  DisparityImage image = flat(12, 9, 0);
  for (float& d : image.values)
    d = random() % 5 == 0 ? DisparityImage::kNone : static_cast<float>(random() % 1000) / 50;
  estimate_sigma({0.25, 2}, image);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    if (!std::isnan(image.values[i]))
      RC_ASSERT(image.sigma[i] >= 0.25F && image.sigma[i] <= std::sqrt(0.0625F + 4) + 1e-5F);
}

TEST(Sigma, GrowsWithDoubt) {
  DisparityImage image = flat(3, 1, 10);
  image.doubt = {0, 0.5F, 1};
  estimate_sigma({.base = 0.2, .clear = 0.5, .doubtful = 2}, image);
  EXPECT_FLOAT_EQ(image.sigma[0], 0.1F);
  EXPECT_FLOAT_EQ(image.sigma[1], 0.2F);
  EXPECT_FLOAT_EQ(image.sigma[2], 0.5F);
}

TEST(Weight, FallsWithDoubt) {
  DisparityImage image = flat(4, 1, 10);
  image.doubt = {0, 0.5F, 1, DisparityImage::kNone};
  estimate_weight({.worst = 0.8}, image);
  EXPECT_EQ(image.weight[0], 1);
  EXPECT_FLOAT_EQ(image.weight[1], 0.9F);
  EXPECT_FLOAT_EQ(image.weight[2], 0.2F);
  EXPECT_TRUE(std::isnan(image.weight[3]));
}

TEST(Weight, IsEmptyWithoutADoubt) {
  DisparityImage image = flat(5, 5, 3);
  image.weight.assign(25, 1);
  estimate_weight({}, image);
  EXPECT_TRUE(image.weight.empty());
}

}  // namespace
}  // namespace headway::vision
