// Judges a floor map by the simulated world's truth: where it shows obstacles that are not there.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "hal/pose2.h"
#include "nav/floor_map.h"
#include "sim_hal/scene.h"

namespace headway::app {

struct FalseObstacleLimits {
  double within = 3.0;   ///< of a place on the robot's way [m]
  double margin = 0.10;  ///< two cells: obstacles may seem so much larger than they are [m]
  double fringe = 0.25;  ///< what lies nearer to a thing is its blurred edge, no floor on its own [m]
};

/// Where the robot was, from time 0 on.
struct RobotWay {
  const std::vector<Pose2>& poses;
  Duration period;  ///< between them
};

/// Blocked cells on the world's floor, near the robot's way, farther than the margin from all that counts as
/// an obstacle, moving things wherever their paths lead.
struct FalseObstacles {
  std::vector<Eigen::Vector2i> floor;      ///< with nothing near: level floor that seems to rise
  std::vector<Eigen::Vector2i> from_afar;  ///< the same, but last seen from farther than `within`
  std::vector<Eigen::Vector2i> fringe;     ///< around things
};
FalseObstacles false_obstacles(const nav::FloorMap& floor, const nav::FloorMapConfig& config,
                               const sim::Scene& scene, const RobotWay& way,
                               const FalseObstacleLimits& limits = {});

}  // namespace headway::app
