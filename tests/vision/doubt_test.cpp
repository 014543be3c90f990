#include "vision/doubt.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/every_target.h"
#include "tests/vision/any_disparities.h"

namespace headway::vision {
namespace {

/// A wall at 10 px and, from column 20 on, one at `beyond`; every match with the same ambiguity.
DisparityImage two_walls(float beyond, float ambiguity) {
  DisparityImage image;
  image.resize(40, 15);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) image.values[image.index(u, v)] = u < 20 ? 10 : beyond;
  image.ambiguity.assign(image.values.size(), ambiguity);
  return image;
}

float doubt_at(DisparityImage& image, int u, int v) {
  estimate_doubt({}, image);
  return image.doubt[image.index(u, v)];
}

TEST(Doubt, IsTheAmbiguityOfASurface) {
  DisparityImage image = two_walls(10, 0.4F);
  for (const int v : {0, 7, 14})
    for (const int u : {0, 1, 20, 38, 39}) EXPECT_FLOAT_EQ(doubt_at(image, u, v), 0.4F);
}

TEST(Doubt, GrowsBesideStepsAndGaps) {
  DisparityImage image = two_walls(13, 0.4F);
  for (const int u : {18, 19, 20, 21})
    EXPECT_FLOAT_EQ(doubt_at(image, u, 7), (6 * 0.4F + 3) / 9) << "a column of three lies beyond the step";
  EXPECT_FLOAT_EQ(doubt_at(image, 17, 7), 0.4F);
  image.values[image.index(5, 7)] = image.ambiguity[image.index(5, 7)] = DisparityImage::kNone;
  EXPECT_FLOAT_EQ(doubt_at(image, 7, 5), (8 * 0.4F + 1) / 9);
  EXPECT_TRUE(std::isnan(doubt_at(image, 5, 7)));
}

TEST(Doubt, GrowsBesideMatchesThatBarelyWon) {
  DisparityImage image = two_walls(10, 0);
  image.ambiguity[image.index(12, 7)] = 0.9F;
  EXPECT_FLOAT_EQ(doubt_at(image, 10, 5), 0.1F);
  EXPECT_FLOAT_EQ(doubt_at(image, 12, 7), 0.1F);
  EXPECT_FLOAT_EQ(doubt_at(image, 11, 7), 0);
}

TEST(Doubt, IsEmptyWhereTheMatcherTellsNoAmbiguity) {
  DisparityImage image = two_walls(10, 0);
  image.ambiguity.clear();
  estimate_doubt({}, image);
  EXPECT_TRUE(image.doubt.empty());
}

float by_definition(const DisparityImage& image, int u, int v, float jump) {
  const float own = image.values[image.index(u, v)];
  double sum = 0;
  for (const int down : {-2, 0, 2})
    for (const int right : {-2, 0, 2}) {
      const std::size_t i =
          image.index(std::clamp(u + right, 0, image.width - 1), std::clamp(v + down, 0, image.height - 1));
      const bool same_surface = !std::isnan(image.values[i]) && std::abs(image.values[i] - own) <= jump;
      sum += same_surface ? static_cast<double>(image.ambiguity[i]) : 1;
    }
  return std::isnan(own) ? own : static_cast<float>(sum / 9);
}

RC_GTEST_PROP(Doubt, IsTheMeanOfTheNineOnEveryTarget, (std::uint64_t seed)) {
  DisparityImage image = any_disparities(seed);
  std::vector<float> first;
  headway::test::on_every_target([&](const char* target) {
    estimate_doubt({.jump = 1}, image);
    RC_ASSERT(image.doubt.size() == image.values.size());
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        const float doubt = image.doubt[image.index(u, v)], expected = by_definition(image, u, v, 1);
        RC_ASSERT(std::isnan(doubt) == std::isnan(expected));
        if (!std::isnan(doubt) && !(std::abs(doubt - expected) <= 1e-6F && doubt <= 1))
          RC_FAIL(std::string(target));
      }
    if (first.empty()) first = image.doubt;
    RC_ASSERT(std::memcmp(first.data(), image.doubt.data(), first.size() * sizeof(float)) == 0);
  });
}

}  // namespace
}  // namespace headway::vision
