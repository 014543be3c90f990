// What the planner may walk on, and what it weighs.
#pragma once

#include <cstddef>

#include "nav/ground.h"

namespace headway::nav {

struct PlannerConfig {
  UnseenFloor unseen = UnseenFloor::kCostly;
  double unseen_price = 2.0;  ///< walking time added on unseen floor, as a share of walking straight over it
  double corridor = 0.15;     ///< half side of the square around the base whose unseen share is priced [m]
  double near_price = 1.0;    ///< walking time added right beside an obstacle, same unit
  double near_range = 0.70;   ///< where that price has fallen to nothing, from the base [m]
  double turn_price = 1.0;    ///< weight of the time that turns take
  double mode_change = 1.6;   ///< from forward to sideway or back [s]
  /// Costs are counted in this fraction of the time that one cell straight on takes. With 12, a diagonal's 17
  /// are a sixth of a percent off, and the dearest walk is as long as 5461 cells straight on.
  int ticks_per_cell = 12;
  /// Chunks of 16 cells that may be worked on after a path within `bound` is known, to better it to the
  /// optimum.
  std::size_t budget = 4'000'000;
  bool start_is_free = true;  ///< the body's own place at the start counts as free, whatever the map says

  /// Throws InputError `planner: key: what, expected what`.
  void validate() const;
};

}  // namespace headway::nav
