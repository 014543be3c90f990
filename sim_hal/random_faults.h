// Fault plans made up from a seed, for campaigns of many runs.
#pragma once

#include <cstdint>

#include "sim_hal/faults.h"

namespace headway::sim {

struct RandomFaultsConfig {
  int fewest = 1, most = 3;
  Duration walk = seconds(15);         ///< they begin within this time after the first step
  double shortest = 0.1, longest = 6;  ///< how long they last [s]; short ones as often as long ones
};

/// Every kind is as likely as any other, and so is every moment of the walk. The same seed gives the same
/// plan on every machine.
FaultPlan random_faults(std::uint64_t seed, const RandomFaultsConfig& config = {});

}  // namespace headway::sim
