#include "nav/levelling.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/angle.h"
#include "nav/floor_map.h"
#include "nav/integrate.h"
#include "synthetic_room.h"

namespace headway::nav {
namespace {

using Eigen::AngleAxisd, Eigen::Isometry3d, Eigen::Vector3d;

struct HeadError {
  double tilt = 0, roll = 0, height = 0;
};

/// Where the camera is taken to be that truly is at `pose`.
Isometry3d assumed(Isometry3d pose, const HeadError& error) {
  pose.rotate(
      AngleAxisd(Vector3d(error.tilt, 0, error.roll).norm(), Vector3d(error.tilt, 0, error.roll).normalized())
          .inverse());
  pose.translation().z() += error.height;
  return pose;
}

Isometry3d look_ahead(int k) {
  return camera_pose({-1.6, 0, 1.4}, -0.6 + 0.3 * (k % 5), 0.55 + 0.1 * (k % 3));
}

vision::RangeView noisy_look(const SyntheticRoom& room, const Isometry3d& pose, std::uint64_t seed) {
  return look(room, camera_of(170, 240, 0.6), pose,
              {.disparity_sigma = 0.15, .correlation = 2, .outliers = 0.01, .seed = seed}, 0.15);
}

double off_level(const Isometry3d& found, const Isometry3d& truth) {
  const Vector3d up = truth.linear().transpose() * Vector3d::UnitZ();
  return std::acos(std::min(1.0, (found.linear() * up).z()));
}

double number(double lowest, double highest) {
  return lowest + (highest - lowest) * *rc::gen::inRange(0, 1001) / 1000;
}

RC_GTEST_PROP(Levelling, FindsOutWhatTheHeadErrs, ()) {
  const SyntheticRoom room = *rc::gen::arbitrary<bool>() ? SyntheticRoom::furnished() : SyntheticRoom{};
  const HeadError error{number(-1.2, 1.2) * kDegree, number(-0.8, 0.8) * kDegree, number(-0.02, 0.02)};
  Levelling levelling;
  const int seed = *rc::gen::inRange(0, 1000);
  for (int k = 0; k < 5; ++k) {
    const Isometry3d truth = look_ahead(k);
    const Isometry3d found = levelling.level(noisy_look(room, truth, static_cast<std::uint64_t>(seed + k)),
                                             assumed(truth, error), at_seconds(0.1 * k));
    RC_ASSERT(off_level(found, truth) < 0.25 * kDegree);
    RC_ASSERT(std::abs(found.translation().z() - truth.translation().z()) < 0.006);
  }
  RC_ASSERT(levelling.counters().fitted >= 4U);
  RC_ASSERT(std::abs(levelling.tilt() - error.tilt) < 0.15 * kDegree);
  RC_ASSERT(std::abs(levelling.height() - error.height) < 0.005);
}

TEST(Levelling, LeavesPosesAloneThatAreRight) {
  Levelling levelling;
  for (int k = 0; k < 10; ++k) {
    const Isometry3d truth = look_ahead(k);
    const Isometry3d found =
        levelling.level(noisy_look({}, truth, static_cast<std::uint64_t>(k)), truth, at_seconds(0.1 * k));
    EXPECT_LT(off_level(found, truth), 0.1 * kDegree);
  }
  EXPECT_EQ(levelling.counters().refused, 0U);
}

TEST(Levelling, ChangesOnlySlowlyOnceItKnows) {
  Levelling levelling;
  const Isometry3d truth = look_ahead(2);
  for (int k = 0; k < 40; ++k)
    levelling.level(noisy_look({}, truth, static_cast<std::uint64_t>(k)), truth, at_seconds(0.1 * k));
  const double before = levelling.tilt();
  const std::uint64_t refused = levelling.counters().refused;
  for (int k = 40; k < 70; ++k)
    levelling.level(noisy_look({}, truth, static_cast<std::uint64_t>(k)), assumed(truth, {1.2 * kDegree}),
                    at_seconds(0.1 * k));
  EXPECT_EQ(levelling.counters().refused, refused + 30) << "as a ramp that begins before the robot";
  EXPECT_NEAR(levelling.tilt(), before, 1e-9);
}

/// Started on a slope within the limits, which the first views make the head's error.
TEST(Levelling, FindsItsLevelAgainWhenViewsGoOnToDisagree) {
  for (const double slope : {0.8, 1.2, 1.6, 1.9}) {
    Levelling levelling;
    const Isometry3d truth = look_ahead(2);
    int k = 0;
    const auto look_with = [&](const HeadError& error) {
      const auto seed = static_cast<std::uint64_t>(k);
      return levelling.level(noisy_look({}, truth, seed), assumed(truth, error), at_seconds(0.1 * k++));
    };
    while (k < 20) look_with({slope * kDegree});
    EXPECT_NEAR(levelling.tilt(), slope * kDegree, 0.15 * kDegree);
    Isometry3d found;
    while (k < 45) found = look_with({});
    EXPECT_LT(off_level(found, truth), 0.15 * kDegree) << slope << " deg";
    EXPECT_LE(levelling.counters().revised, 1U);
  }
}

TEST(Levelling, BelievesNoViewsThatDisagreeAmongEachOther) {
  Levelling levelling;
  const Isometry3d truth = look_ahead(2);
  for (int k = 0; k < 10; ++k)
    levelling.level(noisy_look({}, truth, static_cast<std::uint64_t>(k)), truth, at_seconds(0.1 * k));
  for (int k = 10; k < 100; ++k)
    levelling.level(noisy_look({}, truth, static_cast<std::uint64_t>(k)),
                    assumed(truth, {(k / 5 % 2 == 0 ? 1.2 : -1.2) * kDegree}), at_seconds(0.1 * k));
  EXPECT_EQ(levelling.counters().revised, 0U);
  EXPECT_LT(std::abs(levelling.tilt()), 0.1 * kDegree);
}

TEST(Levelling, KeepsWhatItKnowsWhereNoFloorIsSeen) {
  Levelling levelling;
  const HeadError error{0.8 * kDegree, 0, 0.01};
  for (int k = 0; k < 5; ++k)
    levelling.level(noisy_look({}, look_ahead(k), static_cast<std::uint64_t>(k)),
                    assumed(look_ahead(k), error), at_seconds(0.1 * k));
  const Isometry3d up = camera_pose({-1.6, 0, 1.4}, 0, -0.4);
  const Isometry3d found = levelling.level(noisy_look({}, up, 7), assumed(up, error), at_seconds(1));
  EXPECT_EQ(levelling.sight(), FloorSight::kTooFew);
  EXPECT_EQ(levelling.counters().unseen, 1U);
  EXPECT_LT(off_level(found, up), 0.15 * kDegree);
}

TEST(Levelling, TakesPosesAsTheyComeWhenItIsOff) {
  LevellingConfig config;
  config.use = false;
  Levelling levelling(config);
  const Isometry3d pose = assumed(look_ahead(0), {0.01});
  EXPECT_TRUE(levelling.level(noisy_look({}, look_ahead(0), 1), pose, at_seconds(0)).isApprox(pose, 0));
}

/// Cells of a level, empty floor that are shown as obstacles.
int floor_in_the_way(bool level, const HeadError& error) {
  LevellingConfig levelling_config;
  levelling_config.use = level;
  Levelling levelling(levelling_config);
  VoxelMapConfig config;
  config.lowest = {-2.8, -2.8, -0.4};
  config.highest = {2.8, 2.8, 2.8};
  VoxelMap map(config);
  Integrator integrator;
  for (int k = 0; k < 30; ++k) {
    const Isometry3d truth = look_ahead(k);
    const vision::RangeView view = noisy_look({}, truth, static_cast<std::uint64_t>(k));
    integrator.integrate(map, view, levelling.level(view, assumed(truth, error), at_seconds(0.1 * k)),
                         at_seconds(0.1 * k));
  }
  const FloorMap floor = floor_map(map);
  int blocked = 0, seen = 0;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      const Eigen::Vector2d p = floor.grid.centre({x, y});
      if (p.x() < -2.4 || p.x() > 1.4 || std::abs(p.y()) > 2.2) continue;  // 3 m ahead, off the walls
      blocked += floor.at({x, y}) == Floor::kBlocked;
      seen += floor.at({x, y}) != Floor::kUnseen;
    }
  }
  EXPECT_GT(seen, 1000);
  return blocked;
}

TEST(Levelling, KeepsTheFloorFromBecomingAnObstacle) {
  for (const double tilt : {-1.0, -0.5, 0.5, 1.0})
    EXPECT_EQ(floor_in_the_way(true, {tilt * kDegree, 0.3 * kDegree, 0.015}), 0) << tilt << " deg";
  EXPECT_GT(floor_in_the_way(false, {1.0 * kDegree, 0.3 * kDegree, 0.015}) +
                floor_in_the_way(false, {-1.0 * kDegree, 0.3 * kDegree, 0.015}),
            0)
      << "or the test shows nothing";
}

}  // namespace
}  // namespace headway::nav
