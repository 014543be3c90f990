#include "vision/camera_intrinsics.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <rapidcheck/gtest.h>

#include "random_rig.h"

namespace headway::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::any_lens;
using test::between;
using test::random_camera;

constexpr int kWidth = 640, kHeight = 480;

cv::Matx33d matrix(const CameraIntrinsics& c) { return {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1}; }

// What OpenCV says of the same lens: the oracle.
Vector2d opencv_pixel(const CameraIntrinsics& c, const Vector3d& point) {
  const std::vector<cv::Point3d> points{{point.x(), point.y(), point.z()}};
  std::vector<cv::Point2d> pixels;
  const cv::Vec3d zero(0, 0, 0);
  switch (c.lens) {
    case LensModel::kRadialTangential:
      cv::projectPoints(points, zero, zero, matrix(c), std::vector{c.k1, c.k2, c.p1, c.p2, c.k3}, pixels);
      break;
    case LensModel::kRational:
      cv::projectPoints(points, zero, zero, matrix(c),
                        std::vector{c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6}, pixels);
      break;
    case LensModel::kEquidistant:
      cv::fisheye::projectPoints(points, pixels, cv::Affine3d::Identity(), matrix(c),
                                 cv::Vec4d(c.k1, c.k2, c.k3, c.k4));
      break;
  }
  return {pixels[0].x, pixels[0].y};
}

RC_GTEST_PROP(CameraIntrinsics, ProjectWhereOpenCvDoes, ()) {
  const CameraIntrinsics camera = random_camera(kWidth, kHeight, any_lens());
  const double z = between(0.2, 10), reach = camera.lens == LensModel::kEquidistant ? 5 : 0.8;
  const Vector3d point = z * Vector3d(between(-reach, reach), between(-reach, reach), 1);
  RC_ASSERT((camera.project(point) - opencv_pixel(camera, point)).norm() < 1e-9);
}

RC_GTEST_PROP(CameraIntrinsics, LookAlongTheRayThatProjectsToThePixel, ()) {
  const CameraIntrinsics camera = random_camera(kWidth, kHeight, any_lens());
  const Vector2d pixel(between(0, kWidth - 1), between(0, kHeight - 1));
  const auto ray = camera.unproject(pixel);
  RC_ASSERT(ray.has_value());
  RC_ASSERT(std::abs(ray->norm() - 1) < 1e-12);
  RC_ASSERT((camera.project(between(0.1, 10) * *ray) - pixel).norm() < 1e-8);
}

RC_GTEST_PROP(CameraIntrinsics, FindTheRayThatWasProjected, ()) {
  const CameraIntrinsics camera = random_camera(kWidth, kHeight, any_lens());
  const double widest = camera.lens == LensModel::kEquidistant ? 1.8 : 0.5;
  const double angle = between(0, widest), around = between(-M_PI, M_PI);
  const Vector3d ray(std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle));
  const auto found = camera.unproject(camera.project(ray));
  RC_ASSERT(found.has_value());
  RC_ASSERT((*found - ray).norm() < 1e-9);
}

TEST(CameraIntrinsics, UndoStrongBarrelsLikeOpenCv) {
  // The wide lens of EuRoC's left camera, to its very corners.
  const CameraIntrinsics camera{.width = 752,
                                .height = 480,
                                .fx = 458.654,
                                .fy = 457.296,
                                .cx = 367.215,
                                .cy = 248.375,
                                .k1 = -0.28340811,
                                .k2 = 0.07395907,
                                .p1 = 0.00019359,
                                .p2 = 1.76187114e-05};
  const cv::Vec4d coefficients(camera.k1, camera.k2, camera.p1, camera.p2);
  for (int v = 0; v < 480; v += 7)
    for (int u = 0; u < 752; u += 7) {
      std::vector<cv::Point2d> out;
      cv::undistortPoints(std::vector<cv::Point2d>{{double(u), double(v)}}, out, matrix(camera), coefficients,
                          cv::noArray(), cv::noArray(), cv::TermCriteria(3, 500, 1e-14));
      const auto ray = camera.unproject(Vector2d(u, v));
      ASSERT_TRUE(ray);
      EXPECT_NEAR(ray->x() / ray->z(), out[0].x, 1e-8);
      EXPECT_NEAR(ray->y() / ray->z(), out[0].y, 1e-8);
    }
}

TEST(CameraIntrinsics, SeeNothingWhereTheRadialCurveHasTurnedBack) {
  CameraIntrinsics camera{.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240};
  camera.k1 = -0.5;  // r (1 - r^2 / 2) is greatest at r = sqrt(2/3), where it is 0.5443
  EXPECT_TRUE(camera.unproject({320 + 500 * 0.53, 240}));
  EXPECT_FALSE(camera.unproject({320 + 500 * 0.55, 240}));
  camera.lens = LensModel::kRational;
  EXPECT_TRUE(camera.unproject({320 + 500 * 0.53, 240}));
  EXPECT_FALSE(camera.unproject({320 + 500 * 0.55, 240}));
  camera.lens = LensModel::kEquidistant;
  EXPECT_TRUE(camera.unproject({320 + 500 * 0.53, 240}));
  EXPECT_FALSE(camera.unproject({320 + 500 * 0.55, 240}));
}

TEST(CameraIntrinsics, ReachBehindOnlyWithAnEquidistantLens) {
  CameraIntrinsics camera{.width = 800, .height = 800, .fx = 200, .fy = 200, .cx = 400, .cy = 400};
  EXPECT_GT(camera.unproject({799, 400})->z(), 0);
  camera.lens = LensModel::kEquidistant;
  const auto ray = camera.unproject({400 + 200 * 1.9, 400});
  ASSERT_TRUE(ray);
  EXPECT_NEAR(ray->z(), std::cos(1.9), 1e-12);
  EXPECT_FALSE(camera.unproject({400 + 200 * 3.2, 400})) << "3.2 rad would be behind the back";
  EXPECT_EQ(*camera.unproject({400, 400}), Vector3d::UnitZ());
}

TEST(CameraIntrinsics, RefuseWhatIsNoPixel) {
  const CameraIntrinsics camera{
      .width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 32, .cy = 24, .k1 = -0.1};
  EXPECT_FALSE(camera.unproject({NAN, 3}));
  EXPECT_FALSE(camera.unproject({INFINITY, 3}));
}

TEST(CameraIntrinsics, KnowWhichLensesDistort) {
  CameraIntrinsics camera;
  EXPECT_FALSE(camera.distorts());
  camera.k5 = 0.1;
  EXPECT_FALSE(camera.distorts()) << "the model has no k5";
  camera.lens = LensModel::kRational;
  EXPECT_TRUE(camera.distorts());
  camera = {};
  camera.lens = LensModel::kEquidistant;
  EXPECT_TRUE(camera.distorts()) << "even without coefficients";
}

}  // namespace
}  // namespace headway::vision
