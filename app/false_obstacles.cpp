#include "app/false_obstacles.h"

#include <algorithm>
#include <limits>

#include "sim_hal/solid.h"

namespace headway::app {

FalseObstacles false_obstacles(const nav::FloorMap& floor, const nav::FloorMapConfig& config,
                               const sim::Scene& scene, const std::vector<Pose2>& way,
                               const FalseObstacleLimits& limits) {
  const sim::Floor& world = scene.world().floor;
  const double size = floor.grid.resolution;
  const auto to_nearest_thing = [&](const Eigen::Vector2d& place) {
    const sim::Solid cell =
        sim::Solid::box({place.x(), place.y(), config.body_height / 2}, {size, size, config.body_height});
    double nearest = std::numeric_limits<double>::infinity();
    for (const sim::Solid& solid : scene.solids()) {
      if (solid.top > config.floor_tolerance && solid.bottom < config.body_height)
        nearest = std::min(nearest, sim::floor_distance(cell, solid));
    }
    return nearest;
  };
  const auto near_way = [&](const Eigen::Vector2d& place) {
    return std::ranges::any_of(
        way, [&](const Pose2& robot) { return (robot.position() - place).norm() <= limits.within; });
  };
  FalseObstacles found;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      const Eigen::Vector2d place = floor.grid.centre({x, y});
      const Eigen::Array2d off = (place - world.centre).cwiseAbs();
      if (floor.at({x, y}) != nav::Floor::kBlocked || (off > world.size.array() / 2).any()) continue;
      if (!near_way(place)) continue;
      const double distance = to_nearest_thing(place);
      if (distance > limits.fringe)
        found.floor.emplace_back(x, y);
      else if (distance > limits.margin)
        found.fringe.emplace_back(x, y);
    }
  }
  return found;
}

}  // namespace headway::app
