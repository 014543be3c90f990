#include "app/plot.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace headway::app {
namespace {

constexpr int kWidth = 384, kHeight = 288;  // the frame is 300 x 200 px, its left upper corner at (64, 36)
const Colour kRed{0, 0, 255};

Colour at(const cv::Mat& image, double share_x, double share_y) {
  return image.at<Colour>(36 + static_cast<int>(200 * (1 - share_y)), 64 + static_cast<int>(300 * share_x));
}

TEST(Plot, PutsValuesWhereTheAxesSay) {
  Plot plot(kWidth, kHeight, {0, 10, "x"}, {0, 100, "y"}, "");
  plot.dots({{5, 25}}, kRed, "");
  const cv::Mat image = plot.finished();
  EXPECT_EQ(at(image, 0.5, 0.25), kRed);
  EXPECT_NE(at(image, 0.5, 0.75), kRed);
}

TEST(Plot, RunsTheOtherWayWhereTheAxisDoes) {
  Plot plot(kWidth, kHeight, {10, 0, "x"}, {100, 0, "y"}, "");
  plot.dots({{2.5, 25}}, kRed, "");
  EXPECT_EQ(at(plot.finished(), 0.75, 0.75), kRed);
  const cv::Mat up = Plot(kWidth, kHeight, {0, 10, "x"}, {0, 1, ""}, "").finished(), down = plot.finished();
  EXPECT_NE(cv::norm(up(cv::Rect(64, 242, 300, 14)), down(cv::Rect(64, 242, 300, 14))), 0) << "its numbers";
}

TEST(Plot, SpacesLogarithmicAxesByFactors) {
  Plot plot(kWidth, kHeight, {1, 100, "x", true}, {0.01, 100, "y", true}, "");
  plot.dots({{10, 0.1}}, kRed, "");
  EXPECT_EQ(at(plot.finished(), 0.5, 0.25), kRed);
}

TEST(Plot, DrawsNothingBesideItsFrame) {
  Plot plot(kWidth, kHeight, {0, 1, ""}, {0, 1, ""}, "");
  const cv::Mat empty = plot.finished();
  plot.line({{-3, -2}, {4, 5}}, kRed, "");
  plot.dots({{1.05, 0.5}, {0.5, -0.05}}, kRed, "");
  plot.cell({-1, 0.2}, {2, 0.3}, kRed);
  const cv::Mat image = plot.finished();
  EXPECT_NE(at(image, 0.5, 0.25), at(empty, 0.5, 0.25));
  for (const cv::Rect& beside : {cv::Rect(0, 0, kWidth, 36), cv::Rect(0, 0, 64, kHeight),
                                 cv::Rect(366, 0, 18, kHeight), cv::Rect(0, 238, kWidth, 50)})
    EXPECT_EQ(cv::norm(image(beside), empty(beside)), 0);
}

TEST(Plot, FillsTheBandBetweenTwoCurves) {
  Plot plot(kWidth, kHeight, {0, 1, ""}, {0, 1, ""}, "");
  plot.band({{0, 0.2}, {1, 0.2}}, {{0, 0.6}, {1, 0.6}}, kRed, "");
  const cv::Mat image = plot.finished();
  EXPECT_EQ(at(image, 0.35, 0.4), kRed);
  EXPECT_NE(at(image, 0.35, 0.1), kRed);
  EXPECT_NE(at(image, 0.35, 0.7), kRed);
}

}  // namespace
}  // namespace headway::app
