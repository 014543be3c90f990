// A whole motion of the robot in the units that travel on the bus, for a control computer that places the
// feet itself. Which steps it means says nav/walking/order_steps.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace headway::hal {

/// Seen from the base frame at its start: carried by the foot that landed last, at rest midway between the
/// feet.
struct WalkOrder {
  /// As WalkOrder.Kind in config/can/headway.dbc.
  enum class Kind : std::uint8_t {
    kStraightWithTurn = 0,  ///< straight to (x, y), turning evenly on the way
    kArc = 1,               ///< around the centre (x, y) by `turn`; (0, 0) turns on the spot
    kNextStep = 2,          ///< one step, which takes the base to (x, y) and `turn`
  } kind = Kind::kStraightWithTurn;
  double x = 0, y = 0;  ///< [m]
  double turn = 0;      ///< counter-clockwise [rad]

  bool operator==(const WalkOrder&) const = default;
};

/// The value that the order message carries: 2 mm, 2 mrad. Orders are expanded on these, so that both sides
/// mean the same steps.
inline WalkOrder quantised(const WalkOrder& order) {
  const auto snap = [](double value, int least) {
    return 2e-3 * std::clamp(static_cast<int>(std::lround(value / 2e-3)), least, -least - 1);
  };
  return {order.kind, snap(order.x, -4096), snap(order.y, -4096), snap(order.turn, -2048)};
}

/// Which order a step belongs to, and which of its steps it is, from 0. The order travels with the first.
struct PartOfOrder {
  WalkOrder order;
  std::uint8_t place = 0;

  bool operator==(const PartOfOrder&) const = default;
};

}  // namespace headway::hal
