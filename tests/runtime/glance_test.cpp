#include "runtime/glance.h"

#include <cmath>

#include <gtest/gtest.h>

#include "hal/error.h"

namespace headway::runtime {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

const hal::HeadAngles kWay{0.1, 0.5};

Matrix3d doubt(double x, double y, double yaw) { return Vector3d(x * x, y * y, yaw * yaw).asDiagonal(); }
const Matrix3d kSure = doubt(0.005, 0.005, 0.002), kTurned = doubt(0.005, 0.005, 0.02);

TEST(Glance, LeavesTheEyesOnTheWayOfOneWhoKnowsHisPlace) {
  Glance glance;
  for (int i = 0; i < 100; ++i) {
    const hal::HeadAngles look = glance.direct(kWay, kSure, 0, at_seconds(0.1 * i));
    EXPECT_EQ(look.tilt, kWay.tilt);
    EXPECT_EQ(look.pan, kWay.pan);
  }
}

TEST(Glance, LooksUpUntilThePlaceIsKnown) {
  Glance glance;
  EXPECT_EQ(glance.direct(kWay, kTurned, 0, at_seconds(1)).tilt, 0);
  EXPECT_EQ(glance.direct(kWay, doubt(0.005, 0.005, 0.007), 0, at_seconds(1.3)).tilt, 0) << "half known";
  EXPECT_EQ(glance.direct(kWay, kSure, 0, at_seconds(1.5)).tilt, kWay.tilt);
}

TEST(Glance, IsShortAndSeldomEvenWhenThePlaceStaysUnknown) {
  const GlanceConfig config;
  Glance glance(config);
  double up = 0, longest = 0, now_up = 0, last = 0;
  for (int i = 0; i < 600; ++i) {
    const bool is_up = glance.direct(kWay, kTurned, 0, at_seconds(0.1 * i)).tilt == 0;
    now_up = is_up ? now_up + 0.1 : 0;
    longest = std::max(longest, now_up);
    up += is_up ? 0.1 : 0;
    last = i;
  }
  EXPECT_LE(longest, to_seconds(config.longest) + 0.15);
  EXPECT_LE(up, 0.1 * last * to_seconds(config.longest) / to_seconds(config.longest + config.apart) * 1.1);
  EXPECT_GE(up, 10);
}

TEST(Glance, LooksAlongTheLineThatIsKnownLeastToBothEnds) {
  const GlanceConfig config;
  Glance glance(config);
  const Matrix3d aside = doubt(0.005, 0.05, 0.002);
  const double one = glance.direct(kWay, aside, 0, at_seconds(0)).pan;
  glance.end(at_seconds(1));
  const double two = glance.direct(kWay, aside, 0, at_seconds(10)).pan;
  EXPECT_NEAR(std::abs(one), config.pan, 1e-9);
  EXPECT_NEAR(two, -one, 1e-9);
  // The same line ahead of a robot that has turned a quarter.
  Glance turned(config);
  EXPECT_NEAR(turned.direct(kWay, aside, 1.4, at_seconds(0)).pan, std::numbers::pi / 2 - 1.4, 1e-9);
}

TEST(Glance, EndsWhenTheHeadIsNeeded) {
  Glance glance;
  EXPECT_EQ(glance.direct(kWay, kTurned, 0, at_seconds(0)).tilt, 0);
  glance.end(at_seconds(0.2));
  EXPECT_EQ(glance.direct(kWay, kTurned, 0, at_seconds(0.3)).tilt, kWay.tilt);
}

TEST(Glance, NamesASettingOutOfBounds) {
  EXPECT_THROW(Glance({.turn = 0}), InputError);
  EXPECT_THROW(Glance({.longest = seconds(-1)}), InputError);
}

}  // namespace
}  // namespace headway::runtime
