#include "vision/triangulation.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "random_rig.h"

namespace headway::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::between;

// A rectified rig of two cameras 33 deg wide, 0.144 m apart.
const RectifiedRig kRig{{640, 480, 1080.301895, 319.5, 239.5}, 0.144, 0, 0.3, 100, 0.3};

ProjectionMatrix left_of(const RectifiedRig& rig) {
  const PinholeCamera& c = rig.camera;
  ProjectionMatrix p;
  p << c.focal, 0, c.cx, 0, 0, c.focal, c.cy, 0, 0, 0, 1, 0;
  return p;
}

ProjectionMatrix right_of(const RectifiedRig& rig) {
  ProjectionMatrix p = left_of(rig);
  p(0, 3) = -rig.camera.focal * rig.baseline;
  return p;
}

Vector2d pixel(const ProjectionMatrix& p, const Vector3d& x) { return (p * x.homogeneous()).hnormalized(); }

double normal(std::mt19937_64& random) {
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * 3.141592653589793 * uniform());
}

// Mean and covariance of many draws.
struct Spread {
  int count = 0;
  Vector3d sum = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();
  void add(const Vector3d& x) { ++count, sum += x, squares += x * x.transpose(); }
  Matrix3d covariance() const {
    const Vector3d mean = sum / count;
    return squares / count - mean * mean.transpose();
  }
};

// How far two covariances are apart where it matters: in units of the second, whitened.
double whitened_difference(const Matrix3d& a, const Matrix3d& b) {
  const Matrix3d l = b.llt().matrixL();
  return (l.inverse() * a * l.inverse().transpose() - Matrix3d::Identity()).norm();
}

struct Pair {
  ProjectionMatrix left, right;
};

// Two cameras a little askew, not rectified; without distortion.
Pair some_pair() {
  const StereoRig rig = test::random_rig();
  const auto matrix = [](const CameraIntrinsics& c, const Eigen::Isometry3d& from_left) {
    Matrix3d k;
    k << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1;
    return ProjectionMatrix(k * from_left.matrix().topRows<3>());
  };
  return {matrix(rig.left, Eigen::Isometry3d::Identity()), matrix(rig.right, rig.right_from_left)};
}

struct Reference {
  Vector3d point;
  std::array<double, 6> covariance;  // xx xy xz yy yz zz, [m^2]
};

// kRig; sigma 0.5 px in each of the four coordinates. From an independent program (numpy; the 4x4
// pseudo-inverse of the paper's equation 3), to six digits. Two million Monte Carlo draws of its own agree to
// 0.5 % up to 5 m, and to 1.1 % at 8 m, where sigma_d / d = 0.036 is no longer quite first order.
const std::array<Reference, 8> kReferences{{
    {{0.072, 0, 0.5}, {2.67769e-08, 0, 0, 2.67769e-08, 0, 1.29132e-06}},
    {{0.072, 0, 1}, {1.07107e-07, 0, 0, 1.07107e-07, 0, 2.06612e-05}},
    {{0.3, 0.2, 1.5}, {2.65760e-06, 2.11984e-06, 1.58988e-05, 2.10050e-06, 1.39463e-05, 1.04597e-04}},
    {{-0.25, -0.3, 2}, {8.99736e-06, 7.98347e-06, -5.32232e-05, 7.86645e-06, -4.95868e-05, 3.30579e-04}},
    {{0.6, -0.4, 3}, {5.28040e-05, -3.92727e-05, 2.94546e-04, 3.07160e-05, -2.23141e-04, 1.67355e-03}},
    {{1, 0.8, 4}, {2.86403e-04, 2.45422e-04, 1.22711e-03, 2.13284e-04, 1.05785e-03, 5.28926e-03}},
    {{0.072, 0, 5}, {2.67769e-06, 0, 0, 2.67769e-06, 0, 1.29132e-02}},
    {{1.2, 1, 8}, {1.68935e-03, 1.49157e-03, 1.19326e-02, 1.32917e-03, 1.05785e-02, 8.46281e-02}},
}};

// Largest difference of two entries, in units of the standard deviations that the entry belongs to.
double largest_relative_difference(const Matrix3d& found, const Matrix3d& expected) {
  const Vector3d deviations = expected.diagonal().cwiseSqrt();
  return ((found - expected).array() / (deviations * deviations.transpose()).array()).abs().maxCoeff();
}

TEST(Covariance, MeetsTheReferenceTable) {
  for (const Reference& r : kReferences) {
    const auto& c = r.covariance;
    Matrix3d expected;
    expected << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
    const Matrix3d found =
        covariance(left_of(kRig), right_of(kRig), r.point, 0.25 * Eigen::Matrix4d::Identity());
    EXPECT_LT(largest_relative_difference(found, expected), 1e-4) << r.point.transpose();
  }
}

RC_GTEST_PROP(Covariance, OfTheGeneralRouteEqualsTheClosedFormOfARectifiedRig, ()) {
  const Vector3d p(between(-1, 1), between(-1, 1), between(0.5, 10));
  const double s = between(0.1, 1), f = kRig.camera.focal, d = kRig.disparity(p.z()), z = p.z();
  // vision.md, "paper mode": independent errors in all four coordinates.
  const Vector3d ex = Vector3d::UnitX(), ey = Vector3d::UnitY();
  const Matrix3d closed = z * z / (f * f) * s * s * (ex * ex.transpose() + 0.5 * ey * ey.transpose()) -
                          z * s * s / (f * d) * (ex * p.transpose() + p * ex.transpose()) +
                          2 * s * s / (d * d) * p * p.transpose();
  const Matrix3d found = covariance(left_of(kRig), right_of(kRig), p, s * s * Eigen::Matrix4d::Identity());
  RC_ASSERT((found - closed).norm() < 1e-9 * closed.norm());
}

RC_GTEST_PROP(Triangulation, FindsThePointThatWasProjected, ()) {
  const auto [left, right] = some_pair();
  const Vector3d p(between(-0.3, 0.3), between(-0.3, 0.3), between(1, 8));
  const auto found = triangulate(left, right, pixel(left, p), pixel(right, p), 0.01);
  RC_ASSERT(found.has_value());
  RC_ASSERT((found->position - p).norm() < 1e-7 * p.norm());
  RC_ASSERT(found->residual < 1e-6);
}

RC_GTEST_PROP(Triangulation, RefusesPointsBehindTheCameras, ()) {
  const Vector3d p(between(-1, 1), between(-1, 1), -between(0.5, 5));
  const ProjectionMatrix left = left_of(kRig), right = right_of(kRig);
  RC_ASSERT(!triangulate(left, right, pixel(left, p), pixel(right, p), 0.1).has_value());
}

TEST(Triangulation, RefusesParallelRays) {
  const Vector2d same(100, 100);
  EXPECT_FALSE(triangulate(left_of(kRig), right_of(kRig), same, same, 0.5).has_value());
  EXPECT_FALSE(triangulate(left_of(kRig), right_of(kRig), same, {99, 100}, 0.5).has_value())
      << "one pixel: 156 m";
}

TEST(Triangulation, RefusesCamerasInOnePlaceAndPixelsThatAreNone) {
  const ProjectionMatrix left = left_of(kRig);
  EXPECT_FALSE(triangulate(left, left, {100, 100}, {90, 100}, 0.5).has_value());
  EXPECT_FALSE(triangulate(left, right_of(kRig), {100, NAN}, {90, 100}, 0.5).has_value());
  EXPECT_FALSE(triangulate(left, right_of(kRig), {100, 100}, {-INFINITY, 100}, 0.5).has_value());
}

TEST(Triangulation, SaysHowFarTheRaysMissEachOther) {
  // One row apart: the point lies half a row off in both images, in two of four coordinates.
  const auto found = triangulate(left_of(kRig), right_of(kRig), {300, 200}, {240, 201}, 0.3);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->residual, std::sqrt(2 * 0.5 * 0.5 / 4), 1e-3);
}

RC_GTEST_PROP(Triangulation, DependsNeitherOnTheUnitNorOnTheScaleOfTheMatrices, ()) {
  const auto [left, right] = some_pair();
  const Vector3d p(between(-0.3, 0.3), between(-0.3, 0.3), between(1, 3));
  const auto off = [] { return Vector2d(between(-0.2, 0.2), between(-0.2, 0.2)); };
  const Vector2d in_left = pixel(left, p) + off(), in_right = pixel(right, p) + off();
  const double unit = std::exp(between(-8, 8));  // how many of it make a metre
  ProjectionMatrix other_left = between(0.01, 100) * left, other_right = -between(0.01, 100) * right;
  other_left.leftCols<3>() /= unit, other_right.leftCols<3>() /= unit;
  const auto one = triangulate(left, right, in_left, in_right, 0.02);
  const auto other = triangulate(other_left, other_right, in_left, in_right, 0.02);
  RC_ASSERT(one.has_value());
  RC_ASSERT(other.has_value());
  RC_ASSERT((other->position / unit - one->position).norm() < 1e-9 * one->position.norm());
  RC_ASSERT(whitened_difference(other->covariance / (unit * unit), one->covariance) < 1e-8);
  RC_ASSERT(std::abs(other->residual - one->residual) < 1e-9);
}

TEST(Triangulation, ErrsAsItsCovarianceSays) {
  // The relative error of an entry is at most sqrt(2 / draws) = 0.41 %: 2 % is 4.8 sigma.
  constexpr int kDraws = 120000;
  const double sigma = 0.5;
  const ProjectionMatrix left = left_of(kRig), right = right_of(kRig);
  std::mt19937_64 random(1);
  for (const Vector3d& p : {Vector3d(0.3, 0.2, 1.5), Vector3d(-0.25, -0.3, 2), Vector3d(0.6, -0.4, 3)}) {
    Spread spread;
    for (int i = 0; i < kDraws; ++i) {
      const auto noise = [&] { return Vector2d(sigma * normal(random), sigma * normal(random)); };
      const auto found = triangulate(left, right, pixel(left, p) + noise(), pixel(right, p) + noise(), sigma);
      ASSERT_TRUE(found.has_value());
      spread.add(found->position - p);
    }
    const Matrix3d expected = covariance(left, right, p, sigma * sigma * Eigen::Matrix4d::Identity());
    EXPECT_LT(largest_relative_difference(spread.covariance(), expected), 0.02) << p.transpose();
  }
}

TEST(RangeViewCovariance, MeetsMonteCarlo) {
  constexpr int kDraws = 200000;  // sqrt(2 / draws) = 0.32 %: 2 % is beyond six sigma
  std::mt19937_64 random(2);
  const PinholeCamera& c = kRig.camera;
  const int u = 500, v = 100;
  DisparityImage disparity;
  disparity.resize(c.width, c.height);
  const double d = kRig.disparity(2.5);
  disparity.values[disparity.index(u, v)] = static_cast<float>(d);
  const RangeView view = range_view(disparity, kRig);

  Spread spread;
  const double half = std::sqrt(3.0) * RangeView::kPixelSigma;
  for (int i = 0; i < kDraws; ++i) {
    const auto in_pixel = [&] { return half * (2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1); };
    const double z = kRig.depth(d + kRig.disparity_sigma * normal(random));
    spread.add(c.point(u + in_pixel(), v + in_pixel(), z));
  }
  EXPECT_LT(largest_relative_difference(spread.covariance(), view.covariance(u, v)), 0.02);
}

RC_GTEST_PROP(RangeViews, HoldTheDepthAndSigmaOfEachDisparity, ()) {
  RectifiedRig rig = kRig;
  rig.camera.width = 4, rig.camera.height = 3;
  rig.disparity_offset = between(-20, 40);
  DisparityImage disparity;
  disparity.resize(4, 3);
  const double z = between(0.4, 30), sigma = between(0.05, 1);
  disparity.values[5] = static_cast<float>(rig.disparity(z));
  disparity.sigma.assign(12, DisparityImage::kNone);
  disparity.sigma[5] = static_cast<float>(sigma);
  const RangeView view = range_view(disparity, rig);
  const double d = rig.camera.focal * rig.baseline / z;
  for (std::size_t i = 0; i < 12; ++i)
    RC_ASSERT(std::isnan(view.depth[i]) == std::isnan(view.sigma_depth[i]));
  RC_PRE(std::abs(sigma / d - kLargestRelativeSigma) > 1e-4);
  RC_ASSERT(std::isnan(view.depth[5]) == (sigma / d > kLargestRelativeSigma));
  if (!std::isnan(view.depth[5])) {
    RC_ASSERT(std::abs(view.depth[5] - z) < 1e-4 * z);
    RC_ASSERT(std::abs(view.sigma_depth[5] - z * sigma / d) < 1e-3 * z * sigma / d);
  }
  RC_ASSERT(std::isnan(view.depth[0]));
}

TEST(RangeViews, DropWhatIsTooNearAndKeepWhatIsBeyondTheMap) {
  RectifiedRig rig = kRig;
  rig.camera.width = 4, rig.camera.height = 1;
  rig.nearest = 1, rig.farthest = 5;
  DisparityImage disparity;
  disparity.resize(4, 1);
  disparity.values = {static_cast<float>(rig.disparity(0.9)), static_cast<float>(rig.disparity(9)), 0, -3};
  const RangeView view = range_view(disparity, rig);
  EXPECT_TRUE(std::isnan(view.depth[0]));
  EXPECT_NEAR(view.depth[1], 9, 1e-4);
  EXPECT_TRUE(std::isnan(view.depth[2])) << "at infinity";
  EXPECT_TRUE(std::isnan(view.depth[3])) << "beyond infinity";
  EXPECT_EQ(view.near, 1);
  EXPECT_EQ(view.far, 5);
}

TEST(RangeViews, TakeMeasuredDepths) {
  const PinholeCamera camera{3, 2, 500, 1, 0.5};
  hal::DepthFrame frame;
  frame.width = 3, frame.height = 2;
  frame.depth = {2, NAN, 0, -1, INFINITY, 0.2F};
  const RangeView view = range_view(frame, camera, 0.5, 8, StereoDepthSigma{150, 0.3});
  EXPECT_FLOAT_EQ(view.depth[0], 2);
  EXPECT_FLOAT_EQ(view.sigma_depth[0], 0.008F) << "2^2 / 150 * 0.3";
  for (std::size_t i = 1; i < 6; ++i) EXPECT_TRUE(std::isnan(view.depth[i])) << i;
  const RangeView depth_camera = range_view(frame, camera, 0.5, 8, DepthCameraSigma{0.001, 0.002});
  EXPECT_FLOAT_EQ(depth_camera.sigma_depth[0], 0.009F) << "0.001 + 0.002 * 2^2";

  frame.width = 2, frame.height = 3;
  const RangeView other = range_view(frame, camera, 0.5, 8, DepthCameraSigma{});
  EXPECT_EQ(other.depth.size(), 6U);
  EXPECT_TRUE(std::isnan(other.depth[0])) << "another size than the camera's: nothing is known";
}

}  // namespace
}  // namespace headway::vision
