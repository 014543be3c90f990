// Rooms made up from a seed in which things come onto the robot's way while it walks, and others leave it.
#pragma once

#include <cstdint>

#include "sim_hal/random_world.h"

namespace headway::sim {

struct RandomMoversConfig {
  RandomWorldConfig room{.room = {7.0, 5.5}, .fewest = 2, .most = 5, .walk = 4.0, .moving_share = 0};
  int most_coming = 2;            ///< things that come onto the way; at least one does
  double going_share = 0.5;       ///< share of the worlds in which one stands on the way and leaves it
  double slow = 0.3, fast = 0.8;  ///< how they move [m/s]
  double from = 2.8;              ///< they set off when the robot has come so near to where they go [m] ...
  double warning = 2.7;  ///< ... sees the place, and could touch them so long after they stand, no sooner [s]
};

/// A room in which a disc of radius `room.clearance` can go from start to goal, whichever of the things have
/// moved, and wherever each is on its way. Each coming thing ends on the shortest way that there is without
/// it and the later ones, the earlier having moved. The same seed gives the same world on every machine.
World random_moving_world(std::uint64_t seed, const RandomMoversConfig& config = {});

}  // namespace headway::sim
