// The census matcher beside OpenCV's semi-global one on real pairs with truth.
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/vision/scene.h"
#include "vision/evaluation.h"
#include "vision/image_files.h"
#include "vision/matchers.h"

namespace headway::vision {
namespace {

struct Pair {
  hal::GrayImage left, right;
  DisparityImage truth;
};

// Half a row lower, as a camera that a knock has turned shows it.
hal::GrayImage lower(const hal::GrayImage& image) {
  hal::GrayImage out = image;
  const auto width = static_cast<std::size_t>(image.width);
  for (std::size_t i = width; i < out.pixels.size(); ++i)
    out.pixels[i] = static_cast<std::uint8_t>((image.pixels[i] + image.pixels[i - width] + 1) / 2);
  return out;
}

/// Wrong by more than 2 px, or missing, over what is known.
double wrong_or_missing(const MatchQuality& q) { return 1 - q.density * (1 - q.bad_2); }

MatchQuality quality(MatcherKind kind, int disparities, const Pair& pair) {
  MatcherConfig config;
  config.kind = kind;
  config.sgbm.uniqueness = 10;
  DisparityImage found;
  make_matcher({0, disparities}, config)->match(pair.left, pair.right, found);
  return compare(found, pair.truth);
}

void expect_better(const Pair& pair, int disparities) {
  const MatchQuality ours = quality(MatcherKind::kCensus, disparities, pair);
  EXPECT_LT(wrong_or_missing(ours), wrong_or_missing(quality(MatcherKind::kSgbm, disparities, pair)));
  EXPECT_GE(ours.ambiguity_auc, 0.85) << "the ambiguity tells right from wrong";
}

void expect_better_askew(const Pair& pair, int disparities) {
  const Pair askew{pair.left, lower(pair.right), pair.truth};
  EXPECT_LT(wrong_or_missing(quality(MatcherKind::kCensus, disparities, askew)),
            wrong_or_missing(quality(MatcherKind::kSgbm, disparities, askew)));
}

Pair of_data(const std::string& name) {
  const auto folder = test::data_folder() / "stereo" / name;
  return {read_gray(folder / "left.png"), read_gray(folder / "right.png"),
          read_disparity(folder / "gt16.png")};
}

TEST(RealPairs, MotorcycleIsMatchedBetterThanBySgbm) {
  if (test::data_folder().empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
  expect_better(of_data("motorcycle"), 64);
  expect_better_askew(of_data("motorcycle"), 64);
}

TEST(RealPairs, TsukubaIsMatchedBetterThanBySgbm) {
  if (test::data_folder().empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
  expect_better(of_data("tsukuba"), 64);
  expect_better_askew(of_data("tsukuba"), 64);
}

TEST(RealPairs, AloeIsMatchedBetterThanBySgbm) {
  const std::filesystem::path folder = "/usr/share/doc/opencv-doc/examples/data";
  if (!std::filesystem::exists(folder / "aloeGT.png")) GTEST_SKIP() << "opencv-doc is not installed";
  const auto half = [&](const char* name, int interpolation) {
    cv::Mat image = cv::imread((folder / name).string(), cv::IMREAD_GRAYSCALE);
    cv::resize(image, image, image.size() / 2, 0, 0, interpolation);
    return hal::GrayImage{image.cols, image.rows, {image.data, image.data + image.total()}};
  };
  Pair pair{half("aloeL.jpg", cv::INTER_AREA), half("aloeR.jpg", cv::INTER_AREA), {}};
  const hal::GrayImage truth = half("aloeGT.png", cv::INTER_NEAREST);
  pair.truth.resize(truth.width, truth.height);
  for (std::size_t i = 0; i < truth.pixels.size(); ++i)
    if (truth.pixels[i] > 0) pair.truth.values[i] = static_cast<float>(truth.pixels[i]) / 2;
  expect_better(pair, 128);
}

}  // namespace
}  // namespace headway::vision
