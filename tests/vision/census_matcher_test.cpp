#define HWY_WANT_AVX3_DL 1  // as the matcher has it

#include "vision/census_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/every_target.h"
#include "tests/heap_count.h"
#include "tests/vision/census_reference.h"
#include "tests/vision/scene.h"

namespace headway::vision {
namespace {

using test::image;
using test::texture;

hal::GrayImage noise(int width, int height, std::uint64_t seed) {
  return image(width, height,
               [&](int u, int v) { return static_cast<std::uint8_t>(255 * test::lattice(u, v, seed)); });
}

// A scene with a step of depth, so that paths jump and views disagree; `d` is where its right view stands.
hal::GrayImage step_seen_from(double d, int width, int height, std::uint64_t seed) {
  return image(width, height, [&](int u, int v) {
    const bool near = v > height / 3 && u + 2 * d > width * 0.4 && u + 2 * d < width * 0.8;
    return texture(u + (near ? 2 * d : d), v, 2.5, seed + near);
  });
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  const auto same = [](float x, float y) {
    return std::memcmp(&x, &y, sizeof x) == 0 || (std::isnan(x) && std::isnan(y));
  };
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), same);
}

double density(const DisparityImage& image) {
  const auto matched =
      std::count_if(image.values.begin(), image.values.end(), [](float d) { return !std::isnan(d); });
  return static_cast<double>(matched) / static_cast<double>(std::max<std::size_t>(1, image.values.size()));
}

CensusConfig any_config() {
  CensusConfig config;
  config.penalties.paths = *rc::gen::inRange(3, 5);
  config.penalties.p1 = *rc::gen::inRange(0, 30);
  config.penalties.p2_least = *rc::gen::inRange(30, 60);
  config.penalties.p2 = *rc::gen::inRange(60, 91);
  config.left_right_difference = *rc::gen::inRange(0, 20);
  config.most_ambiguous = *rc::gen::inRange(60, 101) / 100.0;
  config.speckle_size = *rc::gen::inRange(0, 40);
  config.borders = *rc::gen::arbitrary<bool>();
  return config;
}

RC_GTEST_PROP(CensusMatcher, GivesWhatItsDefinitionsSayOnEveryProcessor, ()) {
  const int width = *rc::gen::inRange(1, 90), height = *rc::gen::inRange(1, 20);
  const DisparityRange range{*rc::gen::inRange(-40, 40), 16 * *rc::gen::inRange(1, 9)};
  const auto seed = *rc::gen::inRange<std::uint64_t>(1, 1000);
  const CensusConfig config = any_config();
  const bool noisy = *rc::gen::inRange(0, 4) == 0;
  const double d = *rc::gen::inRange(-20, 300) / 10.0;
  const auto left = noisy ? noise(width, height, seed) : step_seen_from(0, width, height, seed);
  const auto right = noisy ? noise(width, height, seed + 1) : step_seen_from(d, width, height, seed);
  const DisparityImage expected = test::census_reference(left, right, range, config);
  headway::test::on_every_target([&](const char* target) {
    CensusMatcher matcher(range, config);
    DisparityImage found;
    matcher.match(left, right, found);
    RC_LOG() << target << " " << width << "x" << height << " " << range.lowest << "+" << range.count << '\n';
    RC_ASSERT(same_bits(found.values, expected.values));
    RC_ASSERT(same_bits(found.ambiguity, expected.ambiguity));
  });
}

TEST(CensusMatcher, GivesWhatItsDefinitionsSayForTheWidestSearches) {
  for (const int count : {160, 192, 224, 256}) {
    const auto left = step_seen_from(0, 301, 9, 4), right = step_seen_from(70.3, 301, 9, 4);
    const DisparityImage expected = test::census_reference(left, right, {-3, count}, {});
    EXPECT_GT(density(expected), 0.2);
    headway::test::on_every_target([&](const char* target) {
      CensusMatcher matcher({-3, count});
      DisparityImage found;
      matcher.match(left, right, found);
      EXPECT_TRUE(same_bits(found.values, expected.values)) << target << " " << count;
      EXPECT_TRUE(same_bits(found.ambiguity, expected.ambiguity)) << target << " " << count;
    });
  }
}

// Blocks of rows are an inner matter: an image of many blocks gives the rows that a definition without blocks
// gives.
TEST(CensusMatcher, GivesWhatItsDefinitionsSayInTallImages) {
  const auto left = step_seen_from(0, 150, 140, 9), right = step_seen_from(11, 150, 140, 9);
  const DisparityImage expected = test::census_reference(left, right, {0, 32}, {});
  EXPECT_GT(density(expected), 0.5);
  CensusMatcher matcher({0, 32});
  DisparityImage found;
  matcher.match(left, right, found);
  EXPECT_TRUE(same_bits(found.values, expected.values));
}

RC_GTEST_PROP(CensusMatcher, FindsAnyShiftOfATexture, ()) {
  const double d = *rc::gen::inRange(-80, 480) / 10.0;
  const auto seed = *rc::gen::inRange<std::uint64_t>(1, 1000);
  const auto shifted = [&](double by) {
    return image(160, 60, [&](int u, int v) { return texture(u + by, v, 3, seed); });
  };
  CensusMatcher matcher({-16, 64});
  DisparityImage found;
  matcher.match(shifted(0), shifted(d), found);
  double known = 0, matched = 0, good = 0;
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 160; ++u) {
      if (u - d < 0 || u - d > 159) continue;
      const double value = static_cast<double>(found.values[found.index(u, v)]);
      ++known;
      matched += !std::isnan(value);
      good += std::abs(value - d) < 0.5;
    }
  RC_ASSERT(matched / known > 0.95);
  RC_ASSERT(good / matched > 0.98);
}

RC_GTEST_PROP(CensusMatcher, NeverNamesAPartnerOutsideTheRightImage, ()) {
  const double d = *rc::gen::inRange(-100, 480) / 10.0;
  CensusMatcher matcher({-16, 64});
  DisparityImage found;
  matcher.match(step_seen_from(0, 120, 30, 3), step_seen_from(d, 120, 30, 3), found);
  for (int v = 0; v < found.height; ++v)
    for (int u = 0; u < found.width; ++u) {
      const float value = found.values[found.index(u, v)];
      RC_ASSERT(std::isnan(value) ||
                (static_cast<float>(u) - value >= 0 && static_cast<float>(u) - value <= 119));
    }
}

TEST(CensusMatcher, TellsZeroDisparityFromNoMatch) {
  CensusMatcher matcher({0, 16});
  DisparityImage found;
  const auto scene = image(160, 60, [](int u, int v) { return texture(u, v, 3, 5); });
  matcher.match(scene, scene, found);
  EXPECT_GT(density(found), 0.99);
  for (const float d : found.values) EXPECT_LT(std::abs(d), 0.5F);
}

// What its paths bring along from the border is no match.
TEST(CensusMatcher, FindsNothingInConstantImages) {
  const auto dark = image(200, 80, [](int, int) { return std::uint8_t{30}; });
  CensusMatcher matcher({0, 64});
  DisparityImage found;
  matcher.match(dark, dark, found);
  EXPECT_EQ(density(found), 0);
}

TEST(CensusMatcher, TrustsHardlyAnyMatchBetweenNoises) {
  CensusMatcher matcher({0, 64});
  DisparityImage found;
  matcher.match(noise(200, 80, 1), noise(200, 80, 2), found);
  EXPECT_LT(density(found), 0.2);
  std::size_t trusted = 0;
  for (const float a : found.ambiguity) trusted += a < 0.5F;
  EXPECT_LT(static_cast<double>(trusted), 0.003 * static_cast<double>(found.values.size()));
}

TEST(CensusMatcher, FindsLittleInSwappedImages) {
  CensusMatcher matcher({0, 64});
  DisparityImage found;
  const auto shifted = [](double by) {
    return image(160, 60, [=](int u, int v) { return texture(u + by, v, 3, 8); });
  };
  matcher.match(shifted(25), shifted(0), found);
  EXPECT_LT(density(found), 0.25);
}

// The right view, matched by itself (both images mirrored), finds the same surface where matches are strict.
TEST(CensusMatcher, LeftAndRightViewAgreeWhereTheyMust) {
  CensusConfig strict;
  strict.left_right_difference = 1;
  const int width = 200, height = 60;
  const auto mirrored = [&](const hal::GrayImage& of) {
    return image(width, height, [&](int u, int v) {
      return of.pixels[static_cast<std::size_t>(v * width + width - 1 - u)];
    });
  };
  const auto left = step_seen_from(0, width, height, 6), right = step_seen_from(9, width, height, 6);
  CensusMatcher matcher({0, 32}, strict);
  DisparityImage found, back;
  matcher.match(left, right, found);
  matcher.match(mirrored(right), mirrored(left), back);
  double agree = 0, both = 0;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const float d = found.values[found.index(u, v)];
      if (std::isnan(d)) continue;
      const float other =
          back.values[back.index(width - 1 - static_cast<int>(std::lround(static_cast<float>(u) - d)), v)];
      if (std::isnan(other)) continue;
      ++both;
      agree += std::abs(other - d) <= 1.5F;
    }
  EXPECT_GT(both, 0.7 * width * height);
  EXPECT_GT(agree / both, 0.98);
}

TEST(CensusMatcher, TakesNoMemoryAfterTheFirstPairOfASize) {
  const auto left = step_seen_from(0, 160, 60, 2), right = step_seen_from(7, 160, 60, 2);
  const auto other_left = noise(160, 60, 3), other_right = noise(160, 60, 4);  // as many patches as can be
  CensusMatcher matcher({-16, 64});
  DisparityImage found;
  matcher.match(left, right, found);
  const std::uint64_t before = heap_allocations();
  matcher.match(other_left, other_right, found);
  matcher.match(left, right, found);
  EXPECT_EQ(heap_allocations(), before);
  const hal::GrayImage copy = left;
  EXPECT_GT(heap_allocations(), before) << "the count counts";
}

TEST(CensusMatcher, DoesNotRememberWhatItMatchedBefore) {
  const auto left = step_seen_from(0, 160, 60, 2), right = step_seen_from(7, 160, 60, 2);
  CensusMatcher fresh({0, 64}), used({0, 64});
  DisparityImage expected, found;
  fresh.match(left, right, expected);
  used.match(noise(301, 99, 1), noise(301, 99, 2), found);
  used.match(noise(160, 60, 1), noise(160, 60, 1), found);
  used.match(left, right, found);
  EXPECT_TRUE(same_bits(found.values, expected.values));
  EXPECT_TRUE(same_bits(found.ambiguity, expected.ambiguity));
}

TEST(CensusMatcher, FindsNothingInImagesOfDifferentOrNoSize) {
  CensusMatcher matcher({0, 16});
  DisparityImage found;
  matcher.match(noise(60, 20, 1), noise(59, 20, 1), found);
  EXPECT_EQ(density(found), 0);
  matcher.match({}, {}, found);
  EXPECT_TRUE(found.values.empty());
  hal::GrayImage cut = noise(60, 20, 1);
  cut.pixels.pop_back();
  matcher.match(cut, cut, found);
  EXPECT_EQ(density(found), 0);
}

TEST(CensusMatcher, RefusesSenselessParameters) {
  EXPECT_THROW(CensusMatcher({0, 63}), InputError);
  EXPECT_THROW(CensusMatcher({0, 0}), InputError);
  EXPECT_THROW(CensusMatcher({0, 272}), InputError);
  EXPECT_THROW(CensusMatcher({5000, 64}), InputError);
  CensusConfig config;
  config.penalties.p2 = 120;
  EXPECT_THROW(CensusMatcher({0, 64}, config), InputError);
  config = {};
  config.penalties.paths = 5;
  EXPECT_THROW(CensusMatcher({0, 64}, config), InputError);
}

}  // namespace
}  // namespace headway::vision
