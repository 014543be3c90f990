#include "app/scene_picture.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace headway::app {
namespace {

using Eigen::Vector3d;

const Colour kRed{0, 0, 255}, kGreen{0, 255, 0};
// The eye looks along +x; y points to the left of the picture, z up.
const Lookout kAhead{{0, 0, 0}, {1, 0, 0}, std::numbers::pi / 2};

std::array<Vector3d, 3> wall(double x, double size) {
  return {Vector3d(x, -size, -size), Vector3d(x, size, -size), Vector3d(x, 0, size)};
}

TEST(ScenePicture, ShowsTheNearerOfTwoThingsWhicheverIsDrawnFirst) {
  for (const bool near_first : {true, false}) {
    ScenePicture scene(kAhead, 100, 80);
    if (near_first) scene.triangle(wall(2, 1), {kRed, kRed, kRed});
    scene.triangle(wall(4, 8), {kGreen, kGreen, kGreen});
    if (!near_first) scene.triangle(wall(2, 1), {kRed, kRed, kRed});
    const cv::Mat3b image = scene.finished();
    EXPECT_EQ(image(40, 50), kRed);
    EXPECT_EQ(image(70, 50), kGreen);
  }
}

TEST(ScenePicture, PutsThingsWhereItSaysTheyAre) {
  ScenePicture scene(kAhead, 100, 80);
  const Vector3d at(3, 1, 0.5);
  scene.dot(at, 3, kRed);
  const auto pixel = scene.pixel(at);
  ASSERT_TRUE(pixel);
  EXPECT_EQ(cv::Mat3b(scene.finished())(*pixel), kRed);
  EXPECT_LT(pixel->x, 50) << "y is to the left";
  EXPECT_LT(pixel->y, 40) << "z is up";
}

TEST(ScenePicture, LeavesOutWhatLiesBehindTheEye) {
  ScenePicture scene(kAhead, 60, 40);
  scene.dot({-1, 0, 0}, 5, kRed);
  scene.line({-1, 0, 0}, {1, 0, 0}, kRed, 2);
  scene.triangle(wall(-2, 5), {kRed, kRed, kRed});
  EXPECT_FALSE(scene.pixel({-1, 0, 0}));
  const cv::Mat3b image = scene.finished();
  EXPECT_TRUE(std::all_of(image.begin(), image.end(), [](const Colour& c) { return c == colours::kPaper; }));
}

TEST(ScenePicture, ShowsHiddenLinesFaintly) {
  ScenePicture scene(kAhead, 100, 80);
  scene.triangle(wall(2, 1), {kGreen, kGreen, kGreen});
  scene.line({4, -4, 0}, {4, 4, 0}, kRed, 4, 0.5);
  const cv::Mat3b image = scene.finished();
  EXPECT_EQ(image(40, 10), kRed);
  EXPECT_EQ(image(40, 50), mixed(kGreen, kRed, 0.5));
}

TEST(ScenePicture, ACopyIsAPictureOfItsOwn) {
  ScenePicture scene(kAhead, 60, 40);
  ScenePicture other = scene;
  other.dot({2, 0, 0}, 5, kRed);
  EXPECT_EQ(cv::Mat3b(other.finished())(20, 30), kRed);
  EXPECT_EQ(cv::Mat3b(scene.finished())(20, 30), colours::kPaper);
}

TEST(Framing, ShowsAllPointsAndNotMuchElse) {
  const std::vector<Vector3d> points{{0, 0, 0}, {6, 2, 1}, {6, -2, -2}, {3, 0, 4}};
  const Lookout from = framing(points, -1.2, 0.3, 400, 300);
  const ScenePicture scene(from, 400, 300);
  cv::Rect box;
  for (const Vector3d& p : points) {
    const auto pixel = scene.pixel(p);
    ASSERT_TRUE(pixel);
    EXPECT_TRUE(cv::Rect(0, 0, 400, 300).contains(*pixel));
    box |= cv::Rect(*pixel, cv::Size(1, 1));
  }
  EXPECT_TRUE(box.width > 330 || box.height > 240) << box;
}

}  // namespace
}  // namespace headway::app
