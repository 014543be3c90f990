#include "vision/field.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/head_kinematics.h"
#include "random_rig.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using test::between;

constexpr double kDegree = std::numbers::pi / 180;

// Square images 33 deg wide and high, 0.144 m apart.
RectifiedRig square_rig() {
  return {{480, 480, 240 / std::tan(16.5 * kDegree), 239.5, 239.5}, 0.144, 0, 0.8, 6};
}

RectifiedRig some_rig() {
  RectifiedRig rig;
  rig.camera = {320, 240, between(200, 600), between(140, 180), between(100, 140)};
  rig.baseline = between(0.03, 0.3);
  rig.disparity_offset = between(-30, 30);
  return rig;
}

// By projection: the oracle that the half-spaces must agree with. Positive inside [px], roughly.
double margin(const RectifiedRig& rig, const Vector3d& p, double near, double far) {
  const PinholeCamera& c = rig.camera;
  if (p.z() <= 0) return -1;
  const double u = c.focal * p.x() / p.z() + c.cx, v = c.focal * p.y() / p.z() + c.cy;
  const double u_right = u - rig.disparity(p.z());
  return std::min({u + 0.5, c.width - 0.5 - u, u_right + 0.5, c.width - 0.5 - u_right, v + 0.5,
                   c.height - 0.5 - v, p.z() - near, far - p.z()});
}

RC_GTEST_PROP(Field, HoldsThePointsThatBothImagesShow, ()) {
  const RectifiedRig rig = some_rig();
  const Field field = field_of(rig, 0.8, 6);
  const double z = between(0.5, 7);
  const Vector3d p(between(-0.8, 0.8) * z, between(-0.8, 0.8) * z, z);
  const double inside = margin(rig, p, 0.8, 6);
  RC_PRE(std::abs(inside) > 1e-6);
  RC_ASSERT(field.contains(p) == (inside > 0));
}

RC_GTEST_PROP(Field, IsTheHullOfItsCorners, ()) {
  const RectifiedRig rig = some_rig();
  const Field field = field_of(rig, 0.8, 6);
  RC_PRE(!field.corners.empty());
  Vector3d mixed = Vector3d::Zero();
  double weights = 0;
  for (const Vector3d& corner : field.corners) {
    const double weight = between(0.01, 1);
    mixed += weight * corner, weights += weight;
    // A corner lies on at least three planes and outside none.
    int on = 0;
    for (const Vector4d& row : field.rows) {
      RC_ASSERT(row.dot(corner.homogeneous()) > -1e-8);
      on += std::abs(row.dot(corner.homogeneous())) < 1e-8;
    }
    RC_ASSERT(on >= 3);
  }
  RC_ASSERT(field.contains(mixed / weights));
}

TEST(Field, OfARectifiedRigHasSixFacesAndEightCorners) {
  const Field field = field_of(square_rig(), 0.8, 6);
  EXPECT_EQ(field.rows.size(), 6U);
  EXPECT_EQ(field.corners.size(), 8U);
}

TEST(Field, LeavesOutNoRowThatMatters) {
  const RectifiedRig rig = square_rig();
  const Field field = field_of(rig, 0.8, 6);
  for (std::size_t left_out = 0; left_out < field.rows.size(); ++left_out) {
    Field fewer = field;
    fewer.rows.erase(fewer.rows.begin() + static_cast<std::ptrdiff_t>(left_out));
    // Just outside the middle of this row's face, only this row says no.
    Vector3d middle = Vector3d::Zero();
    int count = 0;
    for (const Vector3d& corner : field.corners)
      if (std::abs(field.rows[left_out].dot(corner.homogeneous())) < 1e-8) middle += corner, ++count;
    const Vector3d outside = middle / count - 1e-4 * field.rows[left_out].head<3>();
    EXPECT_FALSE(field.contains(outside));
    EXPECT_TRUE(fewer.contains(outside));
  }
}

TEST(Field, IsEmptyWhereTheImagesDoNotOverlap) {
  RectifiedRig rig = square_rig();
  const Field too_near = field_of(rig, 0.05, 0.1);
  EXPECT_TRUE(too_near.corners.empty());
  EXPECT_FALSE(too_near.contains({0.07, 0, 0.07}));
  EXPECT_FALSE(field_of(rig, 2, 1).contains({0, 0, 1.5}));
}

TEST(Field, LeavesOutTheColumnsThatTheRightCameraDoesNotSee) {
  const RectifiedRig rig = square_rig();
  const Field field = field_of(rig, 0.5, 6);
  const double d = rig.disparity(1);
  EXPECT_FALSE(field.contains(rig.camera.point(d - 1.5, 200, 1)));
  EXPECT_TRUE(field.contains(rig.camera.point(d + 0.5, 200, 1)));
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

TEST(Viewpoints, StayFiniteForAFieldThatIsNone) {
  EXPECT_LE(viewpoints({}, {0, 0}, 5).size(), 10000U);
  EXPECT_GE(viewpoints({}, {10, 10}).size(), 1U);
}

}  // namespace
}  // namespace headway::vision
