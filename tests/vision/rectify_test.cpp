#include "vision/rectify.h"

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "random_rig.h"
#include "tests/vision/scene.h"
#include "vision/cv_image.h"

namespace headway::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::any_lens;
using test::between;
using test::random_rig;

StereoRig ideal_rig() {
  StereoRig rig;
  rig.left = {64, 48, 80, 80, 31.5, 23.5};
  rig.right = rig.left;
  rig.right_from_left.translation().x() = -0.1;
  return rig;
}

RC_GTEST_PROP(Rectifier, PutsPartnersInOneRowAtTheDisparityOfTheirDepth, ()) {
  const StereoRig rig = random_rig(any_lens());
  const Rectifier rectifier(rig);
  const double u = between(0, rig.left.width - 1), v = between(0, rig.left.height - 1), z = between(0.5, 20);
  const Vector3d in_left = z * *rig.left.unproject({u, v});
  const Vector3d in_right = rig.right_from_left * in_left;
  RC_PRE(in_left.z() > 0.3 * z && in_right.z() > 0.3 * z);

  const Vector2d left = rectifier.rectified_left(rig.left.project(in_left));
  const Vector2d right = rectifier.rectified_right(rig.right.project(in_right));
  const Vector3d rectified = rectifier.rectified_from_left() * in_left;
  RC_ASSERT(std::abs(left.y() - right.y()) < 1e-5);
  RC_ASSERT(std::abs(left.x() - right.x() - rectifier.rig().disparity(rectified.z())) < 1e-5);
  // The camera it reports is the one that sees the point there.
  RC_ASSERT((rectifier.camera().point(left.x(), left.y(), rectified.z()) - rectified).norm() < 1e-5 * z);
}

RC_GTEST_PROP(Rectifier, KeepsTheBaselineAndShowsNoBorders, ()) {
  const StereoRig rig = random_rig(any_lens());
  const Rectifier rectifier(rig);
  RC_ASSERT(std::abs(rectifier.baseline() - rig.baseline()) < 1e-12);
  const PinholeCamera& c = rectifier.camera();
  // Every corner of the rectified images looks at something that the raw ones show, to within a pixel.
  const auto shown = [&](const CameraIntrinsics& raw, const Eigen::Isometry3d& turn, double u, double v) {
    const Vector2d at = raw.project(turn.inverse() * c.point(u, v, 1));
    return at.x() > -1 && at.x() < raw.width && at.y() > -1 && at.y() < raw.height;
  };
  for (const double u : {0.0, c.width - 1.0})
    for (const double v : {0.0, c.height - 1.0}) {
      RC_ASSERT(shown(rig.left, rectifier.rectified_from_left(), u, v));
      RC_ASSERT(shown(rig.right, rectifier.rectified_from_right(), u, v));
    }
}

RC_GTEST_PROP(Rectifier, TurnsTheCamerasAsOpenCvDoes, ()) {
  const StereoRig rig = random_rig();
  const Rectifier rectifier(rig);
  const auto matrix = [](const CameraIntrinsics& c) {
    return cv::Matx33d(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  };
  cv::Mat rotation;
  cv::eigen2cv(Eigen::Matrix3d(rig.right_from_left.linear()), rotation);
  const Vector3d t = rig.right_from_left.translation();
  cv::Mat left, right, projection_left, projection_right, depth;
  cv::stereoRectify(matrix(rig.left), cv::noArray(), matrix(rig.right), cv::noArray(),
                    {rig.left.width, rig.left.height}, rotation, cv::Vec3d(t.x(), t.y(), t.z()), left, right,
                    projection_left, projection_right, depth);
  const auto same = [](const Eigen::Isometry3d& ours, const cv::Mat& theirs) {
    Eigen::Matrix3d m;
    cv::cv2eigen(theirs, m);
    return (ours.linear() - m).norm() < 1e-9;
  };
  RC_ASSERT(same(rectifier.rectified_from_left(), left));
  RC_ASSERT(same(rectifier.rectified_from_right(), right));
}

RC_GTEST_PROP(Rectifier, MakesTheImagesThatOpenCvMakes, ()) {
  const StereoRig rig = random_rig(any_lens());
  const Rectifier rectifier(rig);
  const CameraIntrinsics& l = rig.left;
  const auto raw = test::image(l.width, l.height, [](int u, int v) { return test::texture(u, v, 3, 5); });
  hal::GrayImage left, right;
  rectifier.rectify(raw, raw, left, right);

  const PinholeCamera& c = rectifier.camera();
  const cv::Matx33d from(l.fx, 0, l.cx, 0, l.fy, l.cy, 0, 0, 1),
      to(c.focal, 0, c.cx, 0, c.focal, c.cy, 0, 0, 1);
  cv::Mat turn, x, y, expected;
  cv::eigen2cv(Eigen::Matrix3d(rectifier.rectified_from_left().linear()), turn);
  if (l.lens == LensModel::kEquidistant)
    cv::fisheye::initUndistortRectifyMap(from, cv::Vec4d(l.k1, l.k2, l.k3, l.k4), turn, to,
                                         {c.width, c.height}, CV_32FC1, x, y);
  else
    cv::initUndistortRectifyMap(from, std::vector{l.k1, l.k2, l.p1, l.p2, l.k3, l.k4, l.k5, l.k6}, turn, to,
                                {c.width, c.height}, CV_32FC1, x, y);
  cv::remap(as_mat(raw), expected, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  RC_ASSERT(cv::norm(as_mat(left), expected, cv::NORM_INF) <= 8);  // positions are rounded to 1/32 px
  RC_ASSERT(cv::norm(as_mat(left), expected, cv::NORM_L1) < 0.1 * static_cast<double>(left.pixels.size()));
}

RC_GTEST_PROP(Rectifier, LooksUpTheGreyValuesOfTheRawImage, ()) {
  const StereoRig rig = random_rig(any_lens());
  const Rectifier rectifier(rig);
  // A ramp survives interpolation, so each grey value tells the raw column it came from.
  const auto ramp = test::image(rig.left.width, rig.left.height,
                                [](int u, int) { return static_cast<std::uint8_t>(2 * u); });
  hal::GrayImage left, right;
  rectifier.rectify(ramp, ramp, left, right);
  const PinholeCamera& c = rectifier.camera();
  const int u = *rc::gen::inRange(2, c.width - 2), v = *rc::gen::inRange(2, c.height - 2);
  const Vector2d raw = rig.left.project(rectifier.rectified_from_left().inverse() * c.point(u, v, 1));
  const double found = left.pixels[static_cast<std::size_t>(v * c.width + u)];
  RC_ASSERT(std::abs(found - 2 * raw.x()) < 1);
}

TEST(Rectifier, PassesRectifiedPairsUntouched) {
  StereoRig rig = ideal_rig();
  rig.right.cx += 5;  // as in Middlebury's pairs: disparity is counted from other columns
  const Rectifier rectifier(rig);
  ASSERT_TRUE(rectifier.passes_through());
  const auto left = test::image(64, 48, [](int u, int v) { return static_cast<std::uint8_t>(u ^ v); });
  const auto right = test::image(64, 48, [](int u, int v) { return static_cast<std::uint8_t>(u + v); });
  hal::GrayImage left_out, right_out;
  rectifier.rectify(left, right, left_out, right_out);
  EXPECT_EQ(left_out.pixels, left.pixels);
  EXPECT_EQ(right_out.pixels, right.pixels);
  EXPECT_DOUBLE_EQ(rectifier.rig().disparity_offset, 5);

  const Vector3d point(0.1, 0.05, 2);
  const double d = rig.left.project(point).x() - rig.right.project(rig.right_from_left * point).x();
  EXPECT_NEAR(rectifier.rig().depth(d), 2, 1e-12);
  EXPECT_EQ(disparity_range(rectifier.rig()).lowest, -5);
}

TEST(Rectifier, FlattensAFisheyePairWithoutItsDarkCorners) {
  // 195 deg across, the image circle just inside the image: its corners show nothing.
  StereoRig rig;
  rig.left = {.width = 512,
              .height = 512,
              .fx = 190,
              .fy = 190,
              .cx = 255,
              .cy = 255,
              .lens = LensModel::kEquidistant};
  rig.left.k1 = -0.06;
  ASSERT_FALSE(rig.left.unproject({0, 0}));
  rig.right = rig.left;
  rig.right_from_left.translation().x() = -0.1;
  const Rectifier rectifier(rig);
  const PinholeCamera& c = rectifier.camera();
  EXPECT_GT(c.width / c.focal, 2 * std::tan(0.9)) << "more than 100 deg are left";
  EXPECT_TRUE(std::isnan(rectifier.rectified_left({0, 0}).x()));
}

TEST(Rectifier, ShrinksTheImageAndKeepsTheView) {
  const StereoRig rig = ideal_rig();
  const Rectifier full(rig), half(rig, 0.5);
  EXPECT_EQ(half.camera().width, 32);
  EXPECT_EQ(half.camera().height, 24);
  EXPECT_NEAR(half.camera().focal, full.camera().focal / 2, 0.02 * full.camera().focal);
  EXPECT_FALSE(half.passes_through());
}

TEST(Rectifier, RefusesUnusableRigsAndScales) {
  StereoRig rig = ideal_rig();
  EXPECT_THROW(Rectifier(rig, 0), InputError);
  EXPECT_THROW(Rectifier(rig, NAN), InputError);
  rig.right_from_left.translation().x() = 0.1;
  EXPECT_THROW(Rectifier{rig}, InputError);
}

}  // namespace
}  // namespace headway::vision
