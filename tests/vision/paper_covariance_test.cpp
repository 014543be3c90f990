#include "vision/paper_covariance.h"

#include <Eigen/Dense>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "random_rig.h"

namespace headway::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using test::between;

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

Vector3d some_point() { return {between(-1, 1), between(-1, 1), between(0.5, 8)}; }

// Any errors of the four pixel coordinates, correlated or not [px^2].
Matrix4d some_pixel_covariance() {
  Matrix4d root;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) root(i, j) = (i == j ? 0.3 : 0) + between(-0.1, 0.1);
  return root * root.transpose() + 0.01 * Matrix4d::Identity();
}

// The same cameras where a length of 1 m is `per_metre` long.
ProjectionMatrix in_units(ProjectionMatrix p, double per_metre) {
  p.leftCols<3>() /= per_metre;
  return p;
}

// How far two covariances are apart where it matters: in units of the second, whitened.
double whitened_difference(const Matrix3d& a, const Matrix3d& b) {
  const Matrix3d l = b.llt().matrixL();
  return (l.inverse() * a * l.inverse().transpose() - Matrix3d::Identity()).norm();
}

RC_GTEST_PROP(PaperCovariance, EqualsTheThreeByThreeRoute, ()) {
  const auto [left, right] = some_pair();
  const Vector3d p = some_point();
  const Matrix4d pixels = some_pixel_covariance();
  const Matrix3d paper = with_paper_covariance(left, right, p.homogeneous(), pixels).euclidean_covariance();
  const Matrix3d direct = covariance(left, right, p, pixels);
  RC_ASSERT((paper - direct).norm() < 1e-9 * direct.norm());
  RC_ASSERT(whitened_difference(paper, direct) < 1e-9);
}

RC_GTEST_PROP(PaperCovariance, DoesNotDependOnTheScaleOfThePointOrTheMatrices, ()) {
  const auto [left, right] = some_pair();
  const Vector3d p = some_point();
  const Matrix4d pixels = some_pixel_covariance();
  const double scale = (*rc::gen::arbitrary<bool>() ? 1 : -1) * std::exp(between(-7, 7));
  const Matrix3d one = with_paper_covariance(left, right, p.homogeneous(), pixels).euclidean_covariance();
  const Matrix3d other =
      with_paper_covariance(left, right, scale * p.homogeneous(), pixels).euclidean_covariance();
  const Matrix3d third =
      with_paper_covariance(-3 * left, 7 * right, p.homogeneous(), pixels).euclidean_covariance();
  RC_ASSERT(whitened_difference(other, one) < 1e-9);
  RC_ASSERT(whitened_difference(third, one) < 1e-9);
}

RC_GTEST_PROP(PaperCovariance, DoesNotDependOnTheUnitOfLength, ()) {
  const auto [left, right] = some_pair();
  const Vector3d p = some_point();
  const Matrix4d pixels = some_pixel_covariance();
  const Matrix3d metres = covariance(left, right, p, pixels);
  const double mm = 1000;
  const Matrix3d direct = covariance(in_units(left, mm), in_units(right, mm), mm * p, pixels) / (mm * mm);
  RC_ASSERT(whitened_difference(direct, metres) < 1e-10);
  const Matrix3d paper =
      with_paper_covariance(in_units(left, mm), in_units(right, mm), (mm * p).homogeneous(), pixels)
          .euclidean_covariance() /
      (mm * mm);
  RC_ASSERT(whitened_difference(paper, metres) < 1e-9);
}

RC_GTEST_PROP(PaperCovariance, LeavesOutTheScaleOfThePoint, ()) {
  const auto [left, right] = some_pair();
  const Vector4d q = between(0.1, 10) * some_point().homogeneous();
  const Matrix4d sigma = with_paper_covariance(left, right, q, some_pixel_covariance()).covariance;
  RC_ASSERT((sigma * q).norm() < 1e-9 * sigma.norm() * q.norm());
}

TEST(PaperCovariance, IsNotTheUpperLeftOfTheFourByFour) {
  ProjectionMatrix left, right;
  left << 1080, 0, 320, 0, 0, 1080, 240, 0, 0, 0, 1, 0;
  right = left;
  right(0, 3) = -1080 * 0.144;
  const auto sigma_z = [&](double unit) -> Eigen::Vector2d {
    const Vector4d q(0.072 * unit, 0, unit, 1);
    const auto point =
        with_paper_covariance(in_units(left, unit), in_units(right, unit), q, 0.25 * Matrix4d::Identity());
    return Eigen::Vector2d(std::sqrt(point.covariance(2, 2)), std::sqrt(point.euclidean_covariance()(2, 2))) /
           unit;
  };
  const double truth = std::sqrt(covariance(left, right, {0.072, 0, 1}, 0.25 * Matrix4d::Identity())(2, 2));
  EXPECT_NEAR(sigma_z(1)[0] / truth, 0.5, 0.01);
  EXPECT_LT(sigma_z(1000)[0] / truth, 0.01) << "in millimetres it is another number";
  EXPECT_NEAR(sigma_z(1)[1] / truth, 1, 1e-9);
  EXPECT_NEAR(sigma_z(1000)[1] / truth, 1, 1e-9);
}

}  // namespace
}  // namespace headway::vision
