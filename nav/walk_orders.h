// From a path of cells to walk orders, and the steps that they mean.
#pragma once

#include <cstdint>
#include <optional>

#include "nav/footsteps.h"

namespace headway::nav {

/// How a path is told to the control computer.
enum class Execution : std::uint8_t {
  kSteps,   ///< each footstep (place_feet)
  kOrders,  ///< whole motions, whose feet it places itself (give_orders)
};

/// Orders along a path, from the stance after the committed steps: arguments as place_feet. A turn on the
/// spot is an arc about the base, each leg goes straight (taking in the last few degrees of a turn), single
/// steps bring the feet together. The walk's steps are those that the orders mean (steps_of), its `orders`
/// say which order each belongs to. Where no order can be given it ends early.
Walk give_orders(const Path& path, const hal::Stance& from, std::optional<hal::Foot> last_foot,
                 const FloorGrid& grid, const GaitLimits& gait);

inline Walk walk_along(Execution execution, const Path& path, const hal::Stance& from,
                       std::optional<hal::Foot> last_foot, const FloorMap& floor, const GaitLimits& gait) {
  return execution == Execution::kOrders ? give_orders(path, from, last_foot, floor.grid, gait)
                                         : place_feet(path, from, last_foot, floor, gait);
}

}  // namespace headway::nav
