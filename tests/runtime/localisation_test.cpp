// Views are aligned with what stands still.
#include "runtime/localisation.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "hal/head_kinematics.h"
#include "tests/runtime/flat_room.h"

namespace headway::runtime {
namespace {

const Boxes kRoom = {box(4.6, 4.8, -2.4, 2.4, 2.2), box(-1.5, 5, 2.2, 2.4, 2.2),
                     box(-1.5, 5, -2.4, -2.2, 2.2)};

/// From 1.4 m above a place, ahead and somewhat down.
Eigen::Isometry3d ahead_of(const Pose2& robot) {
  Eigen::Isometry3d map_from_view = robot.lifted(1.4);
  map_from_view.linear() = map_from_view.linear() * hal::body_from_optical(0.25);
  return map_from_view;
}

/// How far a robot comes to believe that its odometry, which does not err, is off: it walks behind a cart
/// that came in from the side and goes slowly ahead of it [m].
double error_behind_a_cart(bool knows_what_moves) {
  Mapper mapper(small_map(), {});
  Localisation localisation({}, mapper.voxels());
  const nav::PassingObstacles knows_nothing(mapper.floor().grid, {});
  Time now{};
  double most = 0;
  for (int frame = 0; frame < 80; ++frame) {
    now += seconds(0.1);
    const int walked = std::max(0, frame - 20);
    const Pose2 robot{0.025 * walked, 0, 0};
    Boxes boxes = kRoom;
    const double x = 2.2 + 0.01 * walked;
    if (walked > 0) boxes.push_back(box(x, x + 0.8, -1.2, 1.2, 1.8));
    const auto see = [&](const Eigen::Isometry3d& odom_from_view) {
      const auto view = look(boxes, odom_from_view);
      localisation.see(view, odom_from_view, robot.lifted(1.0), now,
                       knows_what_moves ? mapper.passing() : knows_nothing);
      const Eigen::Isometry3d map_from_odom = localisation.map_from_odom().lifted();
      mapper.integrate(view, map_from_odom * odom_from_view, map_from_odom * robot.lifted(1.0), now);
      localisation.learn();
      mapper.project();
    };
    if (walked == 0) see(from_above({1.7, 0}, 4.5));
    see(ahead_of(robot));
    most = std::max(most, ((localisation.map_from_odom() * robot).position() - robot.position()).norm());
  }
  return most;
}

/// The same where all that is steep are kerbs, which go on with the robot [m].
double error_between_kerbs(double lowest) {
  Mapper mapper(small_map(), {});
  LocalisationConfig config;
  config.lowest = lowest;
  config.localise.fewest_patches = 10;
  config.localise.least_known = 0;
  Localisation localisation(config, mapper.voxels());
  const nav::PassingObstacles knows_nothing(mapper.floor().grid, {});
  Time now{};
  double most = 0;
  for (int frame = 0; frame < 60; ++frame) {
    now += seconds(0.1);
    const int walked = std::max(0, frame - 20);
    const Pose2 robot{0.025 * walked, 0, 0};
    Boxes boxes;
    for (const double x : {1.4, 2.0, 2.6})
      boxes.push_back(box(x + 0.01 * walked, x + 0.01 * walked + 0.1, -1.5, 1.5, 0.11));
    const Eigen::Isometry3d odom_from_view = ahead_of(robot);
    const auto view = look(boxes, odom_from_view);
    localisation.see(view, odom_from_view, robot.lifted(1.0), now, knows_nothing);
    const Eigen::Isometry3d map_from_odom = localisation.map_from_odom().lifted();
    mapper.integrate(view, map_from_odom * odom_from_view, map_from_odom * robot.lifted(1.0), now);
    localisation.learn();
    most = std::max(most, ((localisation.map_from_odom() * robot).position() - robot.position()).norm());
  }
  return most;
}

TEST(Localisation, MakesNothingOfWhatIsNearTheFloor) {
  EXPECT_EQ(error_between_kerbs(0.12), 0);
  EXPECT_GT(error_between_kerbs(-1), 0.002) << "it was not put to the test";
}

TEST(Localisation, IsNotDraggedAlongByWhatMoves) {
  EXPECT_LT(error_behind_a_cart(true), 0.01);
  EXPECT_GT(error_behind_a_cart(false), 0.1) << "what moves would drag it";
}

}  // namespace
}  // namespace headway::runtime
