// What the operator wants, on its way to the loop that decides.
#pragma once

#include <cstdint>

#include "hal/exchange.h"
#include "nav/planner.h"

namespace headway::runtime {

struct OperatorOrder {
  enum class Kind : std::uint8_t {
    kGo,    ///< to `goal`, in place of any other
    kStay,  ///< the goal is given up: comes to rest, feet as they land
  } kind = Kind::kStay;
  nav::Goal goal;  ///< in the map frame
};

/// From the thread that hears the operator to the frame loop.
using OperatorOrders = hal::BoundedQueue<OperatorOrder, 16>;

}  // namespace headway::runtime
