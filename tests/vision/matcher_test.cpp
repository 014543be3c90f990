#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core/utility.hpp>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/source_dir/source_dir.h"
#include "tests/vision/scene.h"
#include "vision/disparity_sigma.h"
#include "vision/evaluation.h"
#include "vision/image_files.h"
#include "vision/opencv_matchers.h"
#include "vision/rig_files.h"
#include "vision/stereo.h"

namespace headway::vision {
namespace {

using test::image;
using test::texture;

constexpr int kWidth = 160, kHeight = 60;

// A flat scene at disparity `d`: the right image is the left one, shifted by `d` pixels to the left.
hal::GrayImage shifted(double d, std::uint64_t seed) {
  return image(kWidth, kHeight, [&](int u, int v) { return texture(u + d, v, 3, seed); });
}

struct Match {
  double density = 0;        // of pixels whose partner lies in the right image
  double within_a_half = 0;  // of those matched
};

Match columns_matched(const DisparityImage& found, double d, int from, int to) {
  double known = 0, matched = 0, good = 0;
  for (int v = 0; v < found.height; ++v)
    for (int u = from; u < to; ++u) {
      if (u - d < 0 || u - d > found.width - 1) continue;
      ++known;
      const float value = found.values[found.index(u, v)];
      matched += !std::isnan(value);
      good += std::abs(static_cast<double>(value) - d) < 0.5;
    }
  return {matched / known, good / std::max(1.0, matched)};
}

TEST(Matcher, FindsAnyShiftOfATexture) {
  double within_a_half = 0, shifts = 0;
  rc::check([&] {
    const double d = *rc::gen::inRange(-80, 480) / 10.0;
    const auto seed = *rc::gen::inRange<std::uint64_t>(1, 1000);
    SgbmMatcher matcher({-16, 64});
    DisparityImage found;
    matcher.match(shifted(0, seed), shifted(d, seed), found);
    const Match match = columns_matched(found, d, 0, kWidth);
    RC_ASSERT(match.density > 0.9);
    RC_ASSERT(match.within_a_half > 0.9);  // now and then a texture repeats itself
    within_a_half += match.within_a_half;
    shifts += 1;
  });
  EXPECT_GT(within_a_half, 0.98 * shifts);
}

RC_GTEST_PROP(Matcher, FillsTheLeftBorderWhereTheRightImageShowsIt, ()) {
  const double d = *rc::gen::inRange(10, 80) / 10.0;  // far: nearly all columns have partners
  SgbmMatcher matcher({0, 64});
  DisparityImage found;
  matcher.match(shifted(0, 7), shifted(d, 7), found);
  const Match border = columns_matched(found, d, 0, 64);
  RC_ASSERT(border.density > 0.85);
  RC_ASSERT(border.within_a_half > 0.98);
}

RC_GTEST_PROP(Matcher, NeverNamesAPartnerOutsideTheRightImage, ()) {
  const double d = *rc::gen::inRange(-100, 480) / 10.0;
  SgbmMatcher matcher({-16, 64});
  DisparityImage found;
  matcher.match(shifted(0, 3), shifted(d, 3), found);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const float value = found.values[found.index(u, v)];
      RC_ASSERT(std::isnan(value) ||
                (static_cast<float>(u) - value >= 0 && static_cast<float>(u) - value <= kWidth - 1));
    }
}

TEST(Matcher, TellsZeroDisparityFromNoMatch) {
  SgbmMatcher matcher({0, 16});
  DisparityImage found;
  matcher.match(shifted(0, 5), shifted(0, 5), found);
  EXPECT_GT(columns_matched(found, 0, 0, kWidth).density, 0.95);
  EXPECT_GT(columns_matched(found, 0, 0, kWidth).within_a_half, 0.99);
  matcher.match(shifted(0, 5), shifted(12, 5), found);
  for (int v = 0; v < kHeight; ++v)  // columns that the right image does not show
    for (int u = 0; u < 12; ++u) EXPECT_FALSE(found.values[found.index(u, v)] > static_cast<float>(u));
  EXPECT_GT(columns_matched(found, 12, 12, kWidth).density, 0.9);
}

TEST(Matcher, FindsLittleInSwappedImages) {
  SgbmMatcher matcher({0, 64});
  DisparityImage found;
  matcher.match(shifted(25, 8), shifted(0, 8), found);
  EXPECT_LT(columns_matched(found, 0, 0, kWidth).density, 0.25);
}

TEST(Matcher, FindsNothingInImagesOfDifferentOrNoSize) {
  SgbmMatcher matcher({0, 16});
  DisparityImage found;
  const auto nothing = [&] {
    return std::all_of(found.values.begin(), found.values.end(), [](float d) { return std::isnan(d); });
  };
  matcher.match(shifted(0, 1), image(kWidth - 1, kHeight, [](int, int) { return std::uint8_t{0}; }), found);
  EXPECT_EQ(found.width, kWidth);
  EXPECT_TRUE(nothing());
  matcher.match({}, {}, found);
  EXPECT_TRUE(found.values.empty());
  hal::GrayImage cut = shifted(0, 1);
  cut.pixels.pop_back();
  matcher.match(cut, cut, found);
  EXPECT_TRUE(nothing());
}

TEST(Matcher, RefusesSenselessParameters) {
  EXPECT_THROW(SgbmMatcher({0, 63}), InputError);
  EXPECT_THROW(SgbmMatcher({0, 0}), InputError);
  EXPECT_THROW(SgbmMatcher({0, 64}, {.block = 4}), InputError);
  EXPECT_THROW(SgbmMatcher({0, 64}, {.p1 = 500}), InputError);
}

class OnMotorcycle : public testing::Test {
 protected:
  void SetUp() override {
    if (test::data_folder().empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
    const auto folder = test::data_folder() / "stereo/motorcycle";
    left = read_gray(folder / "left.png");
    right = read_gray(folder / "right.png");
    truth = read_disparity(folder / "gt16.png");
  }
  // The whole way, with the range of disparities that the rig file asks for.
  DisparityImage matched() const {
    StereoVision vision(read_rig(source_dir() / "config/rigs/middlebury_motorcycle.yaml"));
    hal::StereoFrame frame;
    frame.left = left, frame.right = right;
    vision.see(frame);
    return vision.disparity();
  }
  hal::GrayImage left, right;
  DisparityImage truth;
};

TEST_F(OnMotorcycle, FewMatchesAreWrongAndMostAreFound) {
  const MatchQuality q = compare(matched(), truth);
  RecordProperty("bad_2", std::to_string(q.bad_2));
  RecordProperty("density", std::to_string(q.density));
  EXPECT_LE(q.bad_2, 0.06);
  EXPECT_GE(q.density, 0.94);
}

TEST_F(OnMotorcycle, SigmaDescribesTheErrors) {
  const MatchQuality q = compare(matched(), truth);
  EXPECT_GE(q.coverage_3_sigma, 0.95) << "each counted with its weight";
  EXPECT_GE(q.inlier_coverage, 0.985);
  EXPECT_NEAR(q.inlier_z_rms, 1, 0.15) << "neither too sure nor inflated";
  EXPECT_LT(q.sigma_median, 0.31);
  EXPECT_GT(q.outside_hidden + q.outside_at_edge, 0.75) << "what is outside lies at occlusions";
}

TEST_F(OnMotorcycle, MatchesAreTheSameForAnyNumberOfThreads) {
  const int before = cv::getNumThreads();
  const auto bits = [&](int threads) {
    cv::setNumThreads(threads);
    std::vector<float> values = matched().values;
    for (float& d : values)
      if (std::isnan(d)) d = -1000;
    return values;
  };
  EXPECT_EQ(bits(1), bits(2));
  cv::setNumThreads(before);
}

}  // namespace
}  // namespace headway::vision
