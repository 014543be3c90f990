// The simulated robot walks to and fro for hours: what grows, or drifts, shows.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "app/report.h"
#include "app/sim_session.h"

namespace headway::app {

/// What the program holds of the machine.
struct Holdings {
  std::size_t heap = 0;      ///< in use [bytes]
  std::size_t resident = 0;  ///< [bytes]
  int descriptors = 0;
};
Holdings holdings_now();

struct Lap {
  SimOutcome outcome;
  double seconds = 0;  ///< simulated
  Holdings after;
};

/// Whether the laps are as one would be who never tires. Each question is asked of the medians of the second
/// and of the last quarter of the laps: the first still fills the map.
struct Endurance {
  std::size_t laps = 0, arrived = 0;
  double hours = 0;        ///< simulated
  double heap_growth = 0;  ///< [bytes]
  double map_drift = 0;    ///< of the map's error [m]
  int most_descriptors = 0, descriptors_growth = 0;

  /// Why not, a line each; empty when all is well.
  std::vector<std::string> complaints() const;
};
inline constexpr double kHeapMayGrow = 1
                                       << 20;  ///< [bytes]: of a map that still gains a brick here and there
inline constexpr double kMapMayDrift = 0.02;   ///< [m]

Endurance endurance_of(const std::vector<Lap>& laps);

/// From goal to goal in turn until so much simulated time has passed; ends early where the robot falls or
/// collides.
std::vector<Lap> patrol(SimSession& session, const std::vector<nav::Goal>& goals, Duration longest,
                        const std::function<void(const Lap&)>& after_each);

Json patrol_report(const std::vector<Lap>& laps, const Endurance& endurance);

}  // namespace headway::app
