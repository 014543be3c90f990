#include "hal/pose2.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway {
namespace {

Pose2 any_pose() {
  const auto metres = [] { return *rc::gen::inRange(-10000, 10000) * 1e-3; };
  return {metres(), metres(), *rc::gen::inRange(-3141, 3141) * 1e-3};
}

double distance(const Pose2& a, const Pose2& b) {
  return (a.position() - b.position()).norm() + std::abs(wrap_angle(a.yaw - b.yaw));
}

RC_GTEST_PROP(WrapAngle, GivesTheSameDirectionWithinOneTurn, (std::int16_t hundredths)) {
  const double a = hundredths * 0.01;
  const double w = wrap_angle(a);
  RC_ASSERT(w >= -std::numbers::pi && w < std::numbers::pi);
  RC_ASSERT(std::abs(std::sin(w) - std::sin(a)) < 1e-9);
  RC_ASSERT(std::abs(std::cos(w) - std::cos(a)) < 1e-9);
}

RC_GTEST_PROP(Pose2, InterpolatesStraightAndTurnsTheShortWay, ()) {
  const Pose2 a = any_pose(), b = any_pose();
  const double share = *rc::gen::inRange(0, 101) * 0.01;
  const Pose2 middle = interpolate(a, b, share);
  RC_ASSERT((middle.position() - a.position() - share * (b.position() - a.position())).norm() < 1e-9);
  const double turn = wrap_angle(b.yaw - a.yaw);
  RC_ASSERT(std::abs(wrap_angle(middle.yaw - a.yaw - share * turn)) < 1e-9);
}

TEST(WrapAngle, ExcludesPlusPi) { EXPECT_EQ(wrap_angle(std::numbers::pi), -std::numbers::pi); }

RC_GTEST_PROP(Pose2, MultiplyingIsChainingTransforms, ()) {
  const Pose2 a = any_pose(), b = any_pose();
  const Eigen::Vector2d p = any_pose().position();
  RC_ASSERT((((a * b) * p) - (a * (b * p))).norm() < 1e-9);
}

RC_GTEST_PROP(Pose2, TimesItsInverseIsNoMotion, ()) {
  const Pose2 a = any_pose();
  RC_ASSERT(distance(a * a.inverse(), Pose2{}) < 1e-9);
  RC_ASSERT(distance(a.inverse() * a, Pose2{}) < 1e-9);
}

RC_GTEST_PROP(Pose2, LiftedAgreesWithEigenInThePlane, ()) {
  const Pose2 a = any_pose(), b = any_pose();
  const Eigen::Isometry3d chained = a.lifted(1) * b.lifted(0.5);
  const Eigen::Isometry3d lifted = (a * b).lifted(1.5);
  RC_ASSERT(chained.isApprox(lifted, 1e-9));
}

TEST(Pose2, HeadingIsItsXAxis) {
  const Pose2 left{1, 2, std::numbers::pi / 2};
  EXPECT_LT((left.heading() - Eigen::Vector2d(0, 1)).norm(), 1e-12);
  EXPECT_LT((left * Eigen::Vector2d(1, 0) - Eigen::Vector2d(1, 3)).norm(), 1e-12);
}

}  // namespace
}  // namespace headway
