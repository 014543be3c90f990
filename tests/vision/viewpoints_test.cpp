#include "vision/viewpoints.h"

#include <cmath>

#include <gtest/gtest.h>

#include "hal/angle.h"
#include "hal/head_kinematics.h"
#include "vision/rig_polytope.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;

// Square images 33 deg wide and high, 0.144 m apart.
RectifiedRig square_rig() {
  return {{480, 480, 240 / std::tan(16.5 * kDegree), 239.5, 239.5}, 0.144, 0, 0.8, 6};
}

TEST(FieldAngles, GrowWithDistance) {
  const RectifiedRig rig = square_rig();
  EXPECT_NEAR(field_angles(rig, 0.4).horizontal / kDegree, 13.3, 0.1);
  EXPECT_NEAR(field_angles(rig, 1).horizontal / kDegree, 25.3, 0.1);
  EXPECT_NEAR(field_angles(rig, 100).horizontal / kDegree, 32.9, 0.1);
  EXPECT_NEAR(field_angles(rig, 1).vertical / kDegree, 33, 0.01);
  EXPECT_EQ(field_angles(rig, 0.1).horizontal, 0);
  EXPECT_EQ(field_angles(rig, -1).horizontal, 0);
}

// Which share of the directions that the head can point at falls into some view, far away.
double gaze_covered(const hal::HeadLimits& limits, const std::vector<hal::HeadAngles>& views,
                    const FieldAngles& field) {
  const hal::HeadKinematics neck{Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(),
                                 Eigen::Isometry3d(hal::body_from_optical())};
  int seen = 0, all = 0;
  for (double pan = limits.lower.pan; pan <= limits.upper.pan; pan += 0.5 * kDegree)
    for (double tilt = limits.lower.tilt; tilt <= limits.upper.tilt; tilt += 0.5 * kDegree) {
      const Vector3d gaze = neck.chest_from_camera({pan, tilt}).linear().col(2);
      ++all;
      for (const hal::HeadAngles& view : views) {
        const Vector3d p = neck.chest_from_camera(view).linear().transpose() * gaze;
        if (p.z() > 0 && std::abs(p.x()) <= std::tan(field.horizontal / 2) * p.z() &&
            std::abs(p.y()) <= std::tan(field.vertical / 2) * p.z()) {
          ++seen;
          break;
        }
      }
    }
  return static_cast<double>(seen) / all;
}

TEST(Viewpoints, AreNineForThePapersHead) {
  const hal::HeadLimits limits;  // pan -45..45, tilt -30..45 deg
  const FieldAngles field{33 * kDegree, 33 * kDegree};
  const auto views = viewpoints(limits, field);
  EXPECT_EQ(views.size(), 9U);
  EXPECT_EQ(gaze_covered(limits, views, field), 1);
}

TEST(Viewpoints, TakeMoreToShowAllThatTheHeadCan) {
  const RectifiedRig rig = square_rig();
  EXPECT_EQ(viewpoints({}, field_angles(rig, 1000), 0, Coverage::kReach).size(), 16U);
  EXPECT_EQ(viewpoints({}, field_angles(rig, 1), 0, Coverage::kReach).size(), 20U);
}

TEST(Viewpoints, LieWithinTheLimitsAndTurnTheHeadLittle) {
  const hal::HeadLimits limits;
  for (const Coverage coverage : {Coverage::kGaze, Coverage::kReach}) {
    const auto views = viewpoints(limits, {33 * kDegree, 45 * kDegree}, 0.2, coverage);
    for (const auto& view : views) {
      EXPECT_GE(view.pan, limits.lower.pan - 1e-12);
      EXPECT_LE(view.pan, limits.upper.pan + 1e-12);
      EXPECT_GE(view.tilt, limits.lower.tilt - 1e-12);
      EXPECT_LE(view.tilt, limits.upper.tilt + 1e-12);
    }
    for (std::size_t i = 1; i < views.size(); ++i) {
      EXPECT_LE(std::abs(views[i].pan - views[i - 1].pan), 33 * 0.8 * kDegree + 1e-12);
      EXPECT_TRUE(views[i].pan == views[i - 1].pan || views[i].tilt == views[i - 1].tilt)
          << "one joint at a time";
    }
  }
}

// A head whose axes cross in the cameras: nothing but directions count.
hal::HeadKinematics plain_neck() {
  hal::HeadKinematics neck;
  neck.tilt_from_camera.linear() = hal::body_from_optical();
  return neck;
}

TEST(CoveredShares, AreThePapersNine) {
  const hal::HeadLimits limits;
  const RectifiedRig rig = square_rig();
  const Polytope field = rig_polytope(rig, {});
  const auto nine = viewpoints(limits, {33 * kDegree, 33 * kDegree});
  ASSERT_EQ(nine.size(), 9U);
  EXPECT_EQ(covered(field, plain_neck(), limits, nine, 1e6).gaze, 1) << "all directions of gaze, far away";
  EXPECT_NEAR(covered(field, plain_neck(), limits, nine, 1).gaze, 0.89, 0.05) << "not at one metre";
  EXPECT_LT(covered(field, plain_neck(), limits, nine, 1e6).reach, 0.9) << "nor all that the head can show";
}

TEST(CoveredShares, GrowToAllWithTheViewsLaidOutForThem) {
  const hal::HeadLimits limits;
  const RectifiedRig rig = square_rig();
  const Polytope field = rig_polytope(rig, {});
  const auto far_away = viewpoints(limits, field_angles(rig, 1e6), 0, Coverage::kReach),
             near_by = viewpoints(limits, field_angles(rig, 1), 0, Coverage::kReach);
  EXPECT_GT(covered(field, plain_neck(), limits, far_away, 1e6).reach, 0.99);
  EXPECT_GT(covered(field, plain_neck(), limits, near_by, 1).reach, 0.99);
  EXPECT_LT(covered(field, plain_neck(), limits, far_away, 1).reach,
            covered(field, plain_neck(), limits, near_by, 1).reach);
}

TEST(CoveredShares, OfNoViewsAreNothing) {
  const auto shares = covered(rig_polytope(square_rig(), {}), plain_neck(), {}, {}, 2);
  EXPECT_EQ(shares.gaze, 0);
  EXPECT_EQ(shares.reach, 0);
}

TEST(Viewpoints, StayFiniteForAFieldThatIsNone) {
  EXPECT_LE(viewpoints({}, {0, 0}, 5).size(), 10000U);
  EXPECT_GE(viewpoints({}, {10, 10}).size(), 1U);
}

}  // namespace
}  // namespace headway::vision
