#include "hal/head_kinematics.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::hal {
namespace {

/// A neck of about HRP-2's size; the camera sits to the left of the tilt axis and looks a little down.
HeadKinematics neck() {
  HeadKinematics k;
  k.chest_from_pan.translation() << 0.01, 0, 0.33;
  k.pan_from_tilt.translation() << 0.02, 0, 0.05;
  k.tilt_from_camera.linear() = body_from_optical(0.1);
  k.tilt_from_camera.translation() << 0.08, 0.06, 0.07;
  return k;
}

RC_GTEST_PROP(HeadKinematics, LookAtPutsThePointOnTheOpticalAxis, ()) {
  const double distance = *rc::gen::inRange(800, 5000) * 1e-3;
  const double azimuth = *rc::gen::inRange(-1200, 1200) * 1e-3, down = *rc::gen::inRange(-700, 900) * 1e-3;
  const Eigen::Vector3d point =
      Eigen::Vector3d(0, 0, 0.4) + distance * Eigen::Vector3d(std::cos(azimuth) * std::cos(down),
                                                              std::sin(azimuth) * std::cos(down),
                                                              -std::sin(down));
  const HeadKinematics k = neck();
  const Eigen::Vector3d seen = k.chest_from_camera(k.look_at(point)).inverse() * point;
  RC_ASSERT(seen.z() > 0);
  RC_ASSERT(std::hypot(seen.x(), seen.y()) / seen.z() < 1e-3);
}

TEST(HeadKinematics, PositivePanLooksLeftAndPositiveTiltLooksDown) {
  const HeadKinematics k = neck();
  EXPECT_GT(k.chest_from_camera({0.3, 0}).linear().col(2).y(), 0.2);
  EXPECT_LT(k.chest_from_camera({0, 0.3}).linear().col(2).z(), -0.2);
}

TEST(BodyFromOptical, MapsTheOpticalAxesToForwardLeftUp) {
  const Eigen::Matrix3d r = body_from_optical();
  EXPECT_LT((r * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((r * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((r * Eigen::Vector3d::UnitY() + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(r.determinant(), 1, 1e-12);
}

}  // namespace
}  // namespace headway::hal
