#include "runtime/gaze.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/pose2.h"

namespace headway::runtime {
namespace {

TEST(Tour, CompletesADirectionOnlyAfterEnoughFramesThere) {
  Tour tour({{0.1, 0.2}, {-0.3, 0}}, 2);
  EXPECT_FALSE(tour.look({0, 0})) << "not there yet";
  EXPECT_FALSE(tour.look({0.1, 0.2}));
  EXPECT_TRUE(tour.look({0.1, 0.2}));
  EXPECT_EQ(tour.seen(), 1U);
  EXPECT_FALSE(tour.look({0.1, 0.2})) << "the head has not moved on";
  EXPECT_FALSE(tour.look({-0.3, 0}));
  EXPECT_TRUE(tour.look({-0.3, 0}));
  EXPECT_TRUE(tour.done());
  EXPECT_FALSE(tour.look({-0.3, 0}));
}

TEST(Tour, WithoutDirectionsIsDone) { EXPECT_TRUE(Tour().done()); }

hal::HeadKinematics neck() {
  hal::HeadKinematics k;
  k.chest_from_pan.translation() << 0, 0, 0.33;
  k.tilt_from_camera.translation() << 0.035, 0.072, 0.045;
  k.tilt_from_camera.linear() = hal::body_from_optical(0.17);
  return k;
}

// Wherever a place on the floor is that the head can point at, the camera's axis goes through it.
RC_GTEST_PROP(LookAt, PointsTheCamerasAxisAtThePlace, ()) {
  const double distance = *rc::gen::inRange(60, 400) * 0.01, direction = *rc::gen::inRange(-60, 60) * 0.01;
  Eigen::Isometry3d map_from_chest = Pose2{1, -2, 0.7}.lifted(1.0);
  const Eigen::Vector2d floor =
      Pose2{1, -2, 0.7} * Eigen::Vector2d(distance * std::cos(direction), distance * std::sin(direction));
  const Eigen::Vector3d place(floor.x(), floor.y(), 0);
  const hal::HeadLimits wide{{-1.5, -1.5}, {1.5, 1.5}, 1, 1};
  const auto angles = look_at(place, map_from_chest, neck(), wide);
  const Eigen::Vector3d seen = (map_from_chest * neck().chest_from_camera(angles)).inverse() * place;
  RC_ASSERT(seen.z() > 0);
  RC_ASSERT(seen.head<2>().norm() < 1e-3 * seen.z());
}

TEST(LookAt, StaysWithinTheLimits) {
  const hal::HeadLimits limits;
  const auto angles = look_at({-3, 0.1, 0}, Pose2{}.lifted(1.0), neck(), limits);
  EXPECT_GE(angles.pan, limits.lower.pan);
  EXPECT_LE(angles.pan, limits.upper.pan);
  EXPECT_LE(angles.tilt, limits.upper.tilt);
}

}  // namespace
}  // namespace headway::runtime
