#include "vision/resolution.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "random_rig.h"
#include "vision/rig_polytope.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;
using test::between;

RectifiedRig some_rig() {
  RectifiedRig rig;
  rig.camera = {320, 240, between(200, 600), between(140, 180), between(100, 140)};
  rig.baseline = between(0.05, 0.3);
  rig.disparity_offset = between(-20, 20);
  rig.disparity_sigma = between(0.1, 1);
  return rig;
}

Vector3d some_point(const Polytope& field) {
  Vector3d mixed = Vector3d::Zero();
  double weights = 0;
  for (const Vector3d& corner : field.corners) {
    const double weight = between(0.01, 1);
    mixed += weight * corner, weights += weight;
  }
  return mixed / weights;
}

RC_GTEST_PROP(Resolution, IsTheLargestEigenvalueOfTheViewsCovariance, ()) {
  const RectifiedRig rig = some_rig();
  RangeView view;
  view.camera = rig.camera;
  view.depth.assign(320 * 240, 0), view.sigma_depth = view.depth;
  const int u = *rc::gen::inRange(0, 320), v = *rc::gen::inRange(0, 240);
  const double z = between(0.3, 20);
  const std::size_t i = view.index(u, v);
  view.depth[i] = static_cast<float>(z);
  view.sigma_depth[i] = static_cast<float>(z * z * rig.disparity_sigma / (rig.camera.focal * rig.baseline));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(view.covariance(u, v));
  const double expected = std::sqrt(solver.eigenvalues()(2));
  RC_ASSERT(std::abs(resolution(rig, rig.camera.point(u, v, z)) - expected) < 1e-5 * expected);
}

RC_GTEST_PROP(ResolutionPolytope, LiesInTheFieldAndGrowsWithTheResolution, ()) {
  const RectifiedRig rig = some_rig();
  const Polytope field = rig_polytope(rig, {1.5, 8});
  const double fine = between(0.005, 0.5), coarse = fine * between(1, 3);
  const auto small = resolution_polytope(rig, field, fine), large = resolution_polytope(rig, field, coarse);
  if (!small) return;
  RC_ASSERT(large.has_value());
  for (const Vector3d& corner : small->corners) {
    RC_ASSERT(large->contains(corner, 1e-9));
    RC_ASSERT(field.contains(corner, 1e-9));
    RC_ASSERT(resolution(rig, corner) <= fine * (1 + 1e-9));
  }
}

RC_GTEST_PROP(ResolutionPolytope, HoldsTheMiddleOfWhatIsSeenSoWell, ()) {
  const RectifiedRig rig = some_rig();
  const Polytope field = rig_polytope(rig, {1.5, 8});
  const Vector3d p = some_point(field);
  const auto polytope = resolution_polytope(rig, field, 1.02 * resolution(rig, p));
  RC_ASSERT(polytope.has_value());
  // The hull of a lattice of rays lacks a sliver between them.
  RC_ASSERT(polytope->contains(p, 0.02 * p.norm()));
}

TEST(ResolutionPolytope, IsMinimal) {
  RectifiedRig rig;
  rig.camera = {320, 240, 400, 159.5, 119.5};
  rig.baseline = 0.1;
  const auto polytope = resolution_polytope(rig, rig_polytope(rig, {0.8, 6}), 0.03);
  ASSERT_TRUE(polytope);
  EXPECT_TRUE(is_minimal(*polytope, 1e-6));
}

TEST(ResolutionPolytope, IsTheWholeFieldWhenAllOfItIsSeenSoWell) {
  RectifiedRig rig;
  rig.camera = {320, 240, 400, 159.5, 119.5};
  rig.baseline = 0.1;
  const Polytope field = rig_polytope(rig, {0.8, 6});
  const auto all = resolution_polytope(rig, field, 10);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->corners.size(), 8U);
  for (const Vector3d& corner : field.corners) EXPECT_TRUE(all->contains(corner, 1e-9));
}

TEST(ResolutionPolytope, IsNothingWhereNothingIsSeenSoWell) {
  RectifiedRig rig;
  rig.camera = {320, 240, 400, 159.5, 119.5};
  rig.baseline = 0.1;
  EXPECT_FALSE(resolution_polytope(rig, rig_polytope(rig, {0.8, 6}), 0.0001));
}

}  // namespace
}  // namespace headway::vision
