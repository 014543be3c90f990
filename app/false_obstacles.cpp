#include "app/false_obstacles.h"

#include <algorithm>
#include <limits>

#include "sim_hal/solid.h"

namespace headway::app {

namespace {

using Eigen::Vector2d;

constexpr Duration kMoves = seconds(0.2);  // of moving things, from one place looked at to the next

/// All that counts as an obstacle, moving things wherever they may have been: a map remembers what it has not
/// looked at again.
std::vector<sim::Solid> obstacles(const sim::Scene& scene, const nav::FloorMapConfig& config) {
  std::vector<sim::Solid> all = scene.solids();
  for (const sim::MovingThing& moving : scene.world().moving) {
    for (Duration after{}; after <= moving.path.back().after; after += kMoves) {
      all.push_back(moving.thing.solid);
      all.back().pose = moving.pose_at(after);
    }
  }
  std::erase_if(all, [&](const sim::Solid& solid) {
    return solid.top <= config.floor_tolerance || solid.bottom >= config.body_height;
  });
  return all;
}

/// From a cell to the outline of the nearest obstacle [m].
double to_nearest(const std::vector<sim::Solid>& obstacles, const Vector2d& place, double size) {
  const sim::Solid cell = sim::Solid::box({place.x(), place.y(), 0.5}, {size, size, 1});
  double nearest = std::numeric_limits<double>::infinity();
  for (const sim::Solid& solid : obstacles) nearest = std::min(nearest, sim::floor_distance(cell, solid));
  return nearest;
}

/// Where the robot was then.
Vector2d robot_at(const RobotWay& way, Time time) {
  const auto last = static_cast<Duration::rep>(way.poses.size()) - 1;
  return way
      .poses[static_cast<std::size_t>(
          std::clamp<Duration::rep>(time.time_since_epoch() / way.period, 0, last))]
      .position();
}

}  // namespace

FalseObstacles false_obstacles(const nav::FloorMap& floor, const nav::FloorMapConfig& config,
                               const sim::Scene& scene, const RobotWay& way,
                               const FalseObstacleLimits& limits) {
  const sim::Floor& world = scene.world().floor;
  const auto near = [&](const Vector2d& robot, const Vector2d& place) {
    return (robot - place).norm() <= limits.within;
  };
  const std::vector<sim::Solid> things = obstacles(scene, config);
  FalseObstacles found;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      const Vector2d place = floor.grid.centre({x, y});
      const Eigen::Array2d off = (place - world.centre).cwiseAbs();
      if (floor.at({x, y}) != nav::Floor::kBlocked || (off > world.size.array() / 2).any()) continue;
      if (std::ranges::none_of(way.poses, [&](const Pose2& robot) { return near(robot.position(), place); }))
        continue;
      const double distance = to_nearest(things, place, floor.grid.resolution);
      if (distance <= limits.margin) continue;
      if (distance <= limits.fringe)
        found.fringe.emplace_back(x, y);
      else if (near(robot_at(way, floor.seen({x, y})), place))
        found.floor.emplace_back(x, y);
      else
        found.from_afar.emplace_back(x, y);
    }
  }
  return found;
}

}  // namespace headway::app
