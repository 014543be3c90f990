#include "vision/dense_covariance.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "random_rig.h"
#include "tests/every_target.h"
#include "vision/triangulation.h"

namespace headway::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::between;
using Plane = DensePoints::Plane;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

RectifiedRig some_rig() {
  RectifiedRig rig;
  rig.camera = {*rc::gen::inRange(1, 40), *rc::gen::inRange(1, 6), between(100, 1000), between(0, 40),
                between(0, 6)};
  rig.baseline = between(0.05, 0.3);
  rig.disparity_offset = between(-20, 20);
  rig.nearest = between(0.2, 1);
  rig.farthest = 10;
  rig.disparity_sigma = between(0.05, 0.5);
  return rig;
}

// Good disparities and all that a matcher may leave instead of one.
DisparityImage some_disparities(const RectifiedRig& rig, bool with_sigma) {
  DisparityImage disparity;
  disparity.resize(rig.camera.width, rig.camera.height);
  for (float& d : disparity.values) {
    switch (*rc::gen::inRange(0, 10)) {
      case 0:
        d = kNone;
        break;
      case 1:
        d = -static_cast<float>(rig.disparity_offset);
        break;  // at infinity
      case 2:
        d = -std::numeric_limits<float>::infinity();
        break;
      case 3:
        d = std::numeric_limits<float>::infinity();
        break;
      default:
        d = static_cast<float>(between(-2, 200) - rig.disparity_offset);
    }
  }
  if (!with_sigma) return disparity;
  disparity.sigma.assign(disparity.values.size(), kNone);
  for (float& s : disparity.sigma)
    if (*rc::gen::inRange(0, 10) > 0) s = static_cast<float>(between(0.05, 1));
  return disparity;
}

std::vector<float> some_weights(std::size_t count) {
  std::vector<float> weights(count);
  for (float& w : weights) w = static_cast<float>(between(0, 1));
  return weights;
}

Vector3d position(const DensePoints& points, std::size_t i) {
  return Vector3d(points[Plane::kX][i], points[Plane::kY][i], points[Plane::kZ][i]);
}

Matrix3d covariance_of(const DensePoints& points, std::size_t i) {
  const auto at = [&](Plane plane) { return static_cast<double>(points[plane][i]); };
  Matrix3d sigma;
  sigma << at(Plane::kXX), at(Plane::kXY), at(Plane::kXZ), at(Plane::kXY), at(Plane::kYY), at(Plane::kYZ),
      at(Plane::kXZ), at(Plane::kYZ), at(Plane::kZZ);
  return sigma;
}

// Each entry against the standard deviations that it belongs to.
double largest_relative_difference(const Matrix3d& found, const Matrix3d& expected) {
  const Vector3d deviations = expected.diagonal().cwiseSqrt();
  return ((found - expected).array() / (deviations * deviations.transpose()).array()).abs().maxCoeff();
}

// Every pixel of `points` has what `range_view` measures there, with `expected_covariance(u, v, d, sigma_d)`.
template <class Covariance>
void check_points(const DensePoints& points, const DisparityImage& disparity, const RectifiedRig& rig,
                  std::span<const float> weight, const Covariance& expected_covariance) {
  const RangeView view = range_view(disparity, rig);
  for (int v = 0; v < rig.camera.height; ++v)
    for (int u = 0; u < rig.camera.width; ++u) {
      const std::size_t i = view.index(u, v);
      RC_ASSERT(std::isnan(points[Plane::kZ][i]) == std::isnan(view.depth[i]));
      if (std::isnan(view.depth[i])) {
        for (int plane = 0; plane < DensePoints::kWeight; ++plane)
          RC_ASSERT(std::isnan(points[Plane(plane)][i]));
        RC_ASSERT(points[Plane::kWeight][i] == 0);
        continue;
      }
      RC_ASSERT(points[Plane::kWeight][i] == (weight.empty() ? 1 : weight[i]));
      const Vector3d p = rig.camera.point(u, v, static_cast<double>(view.depth[i]));
      RC_ASSERT((position(points, i) - p).norm() < 1e-6 * p.norm());
      const double sigma_d =
          disparity.sigma.empty() ? rig.disparity_sigma : static_cast<double>(disparity.sigma[i]);
      const Matrix3d expected = expected_covariance(p, rig.camera.focal * rig.baseline / p.z(), sigma_d);
      RC_ASSERT(largest_relative_difference(covariance_of(points, i), expected) < 1e-5);
    }
}

RC_GTEST_PROP(DenseCovariance, OfPlaceAndDisparityIsTheFormulaOnEveryTarget,
              (bool with_sigma, bool weighted)) {
  const RectifiedRig rig = some_rig();
  const DisparityImage disparity = some_disparities(rig, with_sigma);
  const auto weight = weighted ? some_weights(disparity.values.size()) : std::vector<float>();
  headway::test::on_every_target([&](const char*) {
    DensePoints points;
    dense_points(disparity, weight, rig, PixelErrors::kPlaceAndDisparity, points);
    check_points(points, disparity, rig, weight, [&](const Vector3d& p, double d, double sigma_d) {
      const double z_over_f = p.z() / rig.camera.focal;
      Matrix3d sigma = std::pow(sigma_d / d, 2) * p * p.transpose();
      sigma(0, 0) += z_over_f * z_over_f / 12, sigma(1, 1) += z_over_f * z_over_f / 12;
      return sigma;
    });
  });
}

// The oracle is the general route of two projection matrices, which knows nothing of disparities.
RC_GTEST_PROP(DenseCovariance, OfFourCoordinatesIsTheGeneralRoutesOnEveryTarget,
              (bool with_sigma, bool weighted)) {
  const RectifiedRig rig = some_rig();
  const DisparityImage disparity = some_disparities(rig, with_sigma);
  const auto weight = weighted ? some_weights(disparity.values.size()) : std::vector<float>();
  const PinholeCamera& c = rig.camera;
  ProjectionMatrix left, right;
  left << c.focal, 0, c.cx, 0, 0, c.focal, c.cy, 0, 0, 0, 1, 0;
  right = left;
  right(0, 2) += rig.disparity_offset;
  right(0, 3) = -c.focal * rig.baseline;
  headway::test::on_every_target([&](const char*) {
    DensePoints points;
    dense_points(disparity, weight, rig, PixelErrors::kFourCoordinates, points);
    check_points(points, disparity, rig, weight, [&](const Vector3d& p, double, double sigma_d) {
      return covariance(left, right, p, sigma_d * sigma_d / 2 * Eigen::Matrix4d::Identity());
    });
  });
}

RC_GTEST_PROP(DenseCovariance, OfARangeViewIsTheViewsOwnOnEveryTarget, (bool weighted)) {
  const RectifiedRig rig = some_rig();
  const RangeView view = range_view(some_disparities(rig, true), rig);
  const auto weight = weighted ? some_weights(view.depth.size()) : std::vector<float>();
  headway::test::on_every_target([&](const char*) {
    DensePoints points;
    dense_points(view, weight, points);
    for (int v = 0; v < view.camera.height; ++v)
      for (int u = 0; u < view.camera.width; ++u) {
        const std::size_t i = view.index(u, v);
        RC_ASSERT(std::isnan(points[Plane::kXX][i]) == std::isnan(view.depth[i]));
        if (std::isnan(view.depth[i])) continue;
        RC_ASSERT(points[Plane::kZ][i] == view.depth[i]);
        RC_ASSERT(largest_relative_difference(covariance_of(points, i), view.covariance(u, v)) < 1e-5);
        RC_ASSERT(points[Plane::kWeight][i] == (weight.empty() ? 1 : weight[i]));
      }
  });
}

TEST(DenseCovariance, RunsOnMoreThanOneTarget) {
  std::vector<std::string> names;
  headway::test::on_every_target([&](const char* name) { names.emplace_back(name); });
#if defined(__x86_64__)
  EXPECT_GE(names.size(), 2U);
#endif
  EXPECT_FALSE(names.empty());
}

TEST(DensePoints, AreNoneWhereSizesDiffer) {
  const RectifiedRig rig{{4, 2, 500, 2, 1}, 0.1, 0, 0.1, 10};
  DisparityImage disparity;
  disparity.resize(4, 2);
  std::fill(disparity.values.begin(), disparity.values.end(), 50.0F);
  DensePoints points;
  const auto measured = [&](std::span<const float> weight) {
    dense_points(disparity, weight, rig, PixelErrors::kPlaceAndDisparity, points);
    EXPECT_EQ(points.width(), 4);
    EXPECT_EQ(points[Plane::kZ].size(), 8U);
    return std::ranges::count_if(points[Plane::kZ], [](float z) { return std::isfinite(z); });
  };
  EXPECT_EQ(measured({}), 8);
  EXPECT_EQ(measured(std::vector<float>(7, 1.0F)), 0);
  EXPECT_EQ(points[Plane::kWeight][0], 0);
  disparity.sigma.assign(9, 0.2F);
  EXPECT_EQ(measured({}), 0);
  disparity.sigma.clear();
  EXPECT_EQ(measured(std::vector<float>(8, 0.5F)), 8);
  disparity.values.resize(6, 50.0F);
  EXPECT_EQ(measured({}), 0);
  EXPECT_TRUE(std::isnan(points[Plane::kXY][7]));
}

TEST(DensePoints, KeepTheirMemory) {
  DensePoints points;
  points.resize(64, 48);
  const float* before = points[Plane::kX].data();
  points.resize(48, 32);
  points.resize(64, 48);
  EXPECT_EQ(points[Plane::kX].data(), before);
}

}  // namespace
}  // namespace headway::vision
