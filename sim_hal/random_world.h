// Rooms made up from a seed, for campaigns of many runs.
#pragma once

#include <cstdint>

#include "sim_hal/world.h"

namespace headway::sim {

struct RandomWorldConfig {
  Eigen::Vector2d room{6.0, 5.0};  ///< inside [m]
  int fewest = 4, most = 9;        ///< obstacles
  double clearance = 0.55;         ///< way kept free for a disc of this radius from start to goal [m]
  double walk = 2.5;               ///< start and goal are at least this far apart [m]
  double moving_share = 0.25;      ///< share of the worlds in which one obstacle moves
};

/// A room in which a disc of radius `clearance` can go from start to goal, also after anything that moves has
/// moved (and wherever it is on its way). The same seed gives the same world on every machine.
World random_world(std::uint64_t seed, const RandomWorldConfig& config = {});

}  // namespace headway::sim
