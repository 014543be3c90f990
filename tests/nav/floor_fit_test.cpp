#include "nav/floor_fit.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/angle.h"
#include "hal/error.h"
#include "synthetic_room.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Vector2d, Eigen::Vector3d;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Ground of any height as a camera sees it, found by steps along each ray.
vision::RangeView look_at(const std::function<double(const Vector2d&)>& ground, const Isometry3d& pose) {
  vision::RangeView view;
  view.camera = camera_of(96, 72, 0.9);
  view.near = 0.4;
  view.far = 6;
  view.depth.assign(96 * 72, kNan);
  view.sigma_depth = view.depth;
  for (int v = 0; v < 72; ++v) {
    for (int u = 0; u < 96; ++u) {
      const Vector3d ray = pose.linear() * view.camera.point(u, v, 1);
      const auto over = [&](double z) {
        const Vector3d p = pose.translation() + z * ray;
        return p.z() - ground(p.head<2>());
      };
      double z = view.near;
      while (z < view.far && over(z) > 0) z += 0.04;
      if (z >= view.far) continue;
      double low = z - 0.04, high = z;
      for (int i = 0; i < 20; ++i) (over((low + high) / 2) > 0 ? low : high) = (low + high) / 2;
      view.depth[view.index(u, v)] = static_cast<float>(high);
      view.sigma_depth[view.index(u, v)] = static_cast<float>(0.002 * high * high);
    }
  }
  return view;
}

const Isometry3d kEye = camera_pose({0, 0, 1.4}, 0.3, 0.6);

FloorFit fit(const std::function<double(const Vector2d&)>& ground) {
  return FloorFitter().fit(look_at(ground, kEye), kEye);
}

double number(double lowest, double highest) {
  return lowest + (highest - lowest) * *rc::gen::inRange(0, 1001) / 1000;
}

RC_GTEST_PROP(FloorFit, FindsAnyPlaneThatCouldBeTheFloor, ()) {
  const double angle = number(-3.1, 3.1), lean = std::tan(number(0, 1.8) * kDegree);
  const Vector2d slope = lean * Vector2d(std::cos(angle), std::sin(angle));
  const double height = number(-0.03, 0.03);
  const FloorFit found = fit([&](const Vector2d& p) { return height + slope.dot(p); });
  RC_ASSERT(found.sight == FloorSight::kPlane);
  RC_ASSERT(std::abs(found.plane.height - height) < 0.002);
  RC_ASSERT((found.plane.slope - slope).norm() < 0.001);
}

RC_GTEST_PROP(FloorFit, IsNotMisledByThingsOnTheFloor, ()) {
  const double x = number(1.0, 2.2), y = number(-0.4, 0.8), size = number(0.1, 0.3),
               height = number(0.05, 0.8);
  const FloorFit found = fit(
      [&](const Vector2d& p) { return (p - Vector2d(x, y)).cwiseAbs().maxCoeff() < size ? height : 0.0; });
  RC_ASSERT(found.sight == FloorSight::kPlane);
  RC_ASSERT(std::abs(found.plane.height) < 0.004);
  RC_ASSERT(found.plane.slope.norm() < 0.004);
}

TEST(FloorFit, KnowsHowWellItIsDetermined) {
  // A view ahead tells of the slope ahead more than of that to the side.
  const FloorFit found =
      FloorFitter().fit(look_at([](const Vector2d&) { return 0.0; }, camera_pose({0, 0, 1.4}, 0, 0.5)),
                        camera_pose({0, 0, 1.4}, 0, 0.5));
  ASSERT_TRUE(found);
  EXPECT_LT(std::sqrt(found.plane.covariance(1, 1)), 0.1 * kDegree);
  EXPECT_LT(std::sqrt(found.plane.covariance(2, 2)), 0.1 * kDegree);
  EXPECT_LT(std::sqrt(found.plane.covariance(0, 0)), 0.003);
}

/// A depth without its deviation says nothing, whatever stands there.
TEST(FloorFit, LeavesOutWhatHasNoDeviation) {
  for (const float bad : {kNan, 0.0F, -1.0F, std::numeric_limits<float>::infinity()}) {
    vision::RangeView view = look_at([](const Vector2d&) { return 0.0; }, kEye);
    for (std::size_t i = 0; i < view.sigma_depth.size(); i += 7) {
      view.sigma_depth[i] = bad;
      view.depth[i] *= 0.9F;
    }
    const FloorFit found = FloorFitter().fit(view, kEye);
    ASSERT_TRUE(found) << bad;
    EXPECT_LT(std::abs(found.plane.height), 0.002);
    EXPECT_LT(found.plane.slope.norm(), 0.001);
  }
}

TEST(FloorFit, TakesNoRampForFloor) {
  EXPECT_EQ(fit([](const Vector2d& p) { return std::tan(3 * kDegree) * p.x(); }).sight,
            FloorSight::kTooSteep);
  for (const double ramp : {5.0, 8.0, 15.0}) {
    const FloorFit found =
        fit([&](const Vector2d& p) { return std::tan(ramp * kDegree) * std::max(0.0, p.x() - 0.9); });
    EXPECT_NE(found.sight, FloorSight::kPlane) << ramp << " deg from 0.9 m on";
  }
}

TEST(FloorFit, TakesNoTableOrPlatformForFloor) {
  EXPECT_EQ(fit([](const Vector2d&) { return 0.72; }).sight, FloorSight::kTooFew) << "a table";
  EXPECT_EQ(fit([](const Vector2d&) { return 0.07; }).sight, FloorSight::kTooHigh) << "a platform all over";
  const FloorFit half = fit([](const Vector2d& p) { return p.y() > 0.9 ? 0.08 : 0.0; });
  EXPECT_EQ(half.sight, FloorSight::kTooSteep) << "half floor, half platform";
  const FloorFit most = fit([](const Vector2d& p) { return p.x() > 1.3 ? 0.08 : 0.0; });
  EXPECT_NE(most.sight, FloorSight::kPlane) << "a step up, and a little floor before it";
}

TEST(FloorFit, TakesNoSurfaceForFloorWhileOthersLieBelowIt) {
  const FloorFit found = fit([](const Vector2d& p) { return p.y() > 1.1 ? -0.3 : 0.0; });
  EXPECT_EQ(found.sight, FloorSight::kNotLowest);
}

TEST(FloorFit, SaysWhenItSeesTooLittle) {
  EXPECT_FALSE(fit([](const Vector2d& p) { return p.x() > 0.9 ? 1.0 : 0.0; })) << "before a chest of drawers";
  const Isometry3d up = camera_pose({0, 0, 1.4}, 0, -0.6);
  EXPECT_EQ(FloorFitter().fit(look_at([](const Vector2d&) { return 0.0; }, up), up).sight,
            FloorSight::kTooFew);
}

TEST(FloorFit, RefusesAConfigurationThatMakesNoSense) {
  for (const FloorFitConfig& config :
       {FloorFitConfig{.range = 0}, {.widest_tilt = 1}, {.greatest_height = -1}, {.least_points = 3}})
    EXPECT_THROW(FloorFitter{config}, InputError);
}

}  // namespace
}  // namespace headway::nav
