#include "nav/walking/support_polygon.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::nav {
namespace {

using Eigen::Vector2d;

double between(double low, double high) { return low + (high - low) * *rc::gen::inRange(0, 10001) / 10000.0; }

RC_GTEST_PROP(SupportPolygon, HoldsExactlyWhatIsBetweenTheSoles, ()) {
  const Pose2 left{between(-1, 1), between(-1, 1), between(-3, 3)},
      right{between(-1, 1), between(-1, 1), between(-3, 3)};
  const double length = 0.2172, width = 0.138;
  const SupportPolygon hull(left, right, length, width);
  // A point of one sole, a point of the other, a point on the way between them: inside.
  const auto on_sole = [&](const Pose2& foot) {
    return Vector2d(foot * Vector2d(between(-length / 2, length / 2), between(-width / 2, width / 2)));
  };
  const Vector2d a = on_sole(left), b = on_sole(right);
  const double share = between(0, 1);
  RC_ASSERT(hull.margin(a + share * (b - a)) >= -1e-12);
  RC_ASSERT(SupportPolygon(left, length, width).margin(a) >= -1e-12);
  // Beyond the farthest corner in any direction: outside by that much or more than nothing.
  const double angle = between(-3.1, 3.1);
  const Vector2d direction(std::cos(angle), std::sin(angle));
  double farthest = -10;
  for (std::size_t i = 0; i < hull.size(); ++i) farthest = std::max(farthest, hull.corner(i).dot(direction));
  const Vector2d middle = (left.position() + right.position()) / 2;
  RC_ASSERT(hull.margin(middle + direction * (farthest - middle.dot(direction) + 1e-6)) < 0);
}

TEST(SupportPolygon, MeasuresTheMarginOfAStandingRobot) {
  const SupportPolygon hull({0, 0.095, 0}, {0, -0.095, 0}, 0.2172, 0.138);
  EXPECT_NEAR(hull.margin({0, 0}), 0.1086, 1e-12);
  EXPECT_NEAR(hull.margin({0, 0.15}), 0.014, 1e-12);
  EXPECT_NEAR(hull.margin({0.2, 0}), -0.0914, 1e-12);
}

}  // namespace
}  // namespace headway::nav
