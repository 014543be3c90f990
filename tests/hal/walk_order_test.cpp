#include "hal/walk_order.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/bus_codec.h"

namespace headway::hal {
namespace {

WalkOrder any_order() {
  const auto between = [](double end) { return *rc::gen::inRange(-1000000, 1000000) * 1e-6 * end; };
  using enum WalkOrder::Kind;
  return {*rc::gen::element(kStraightWithTurn, kArc, kNextStep), between(9), between(9), between(5)};
}

RC_GTEST_PROP(QuantisedOrder, IsWhatTheBusCarriesBitForBit, ()) {
  const WalkOrder sent = quantised(any_order());
  const auto frame =
      bus::WalkOrder{
          .kind = static_cast<bus::WalkOrder::Kind>(sent.kind), .x = sent.x, .y = sent.y, .theta = sent.turn}
          .pack();
  RC_ASSERT(frame.has_value());
  const auto received = bus::WalkOrder::unpack(*frame);
  RC_ASSERT(received.has_value());
  RC_ASSERT(static_cast<WalkOrder::Kind>(received->kind) == sent.kind);
  RC_ASSERT(received->x == sent.x);
  RC_ASSERT(received->y == sent.y);
  RC_ASSERT(received->theta == sent.turn);
}

RC_GTEST_PROP(QuantisedOrder, IsWithinAUnitOfWhatWasAskedUnlessThatCannotTravel, ()) {
  const WalkOrder asked = any_order(), order = quantised(asked);
  RC_ASSERT(std::abs(order.x - asked.x) <= 1e-3 + 1e-12 || std::abs(asked.x) > 8.19);
  RC_ASSERT(std::abs(order.y - asked.y) <= 1e-3 + 1e-12 || std::abs(asked.y) > 8.19);
  RC_ASSERT(std::abs(order.turn - asked.turn) <= 1e-3 + 1e-12 || std::abs(asked.turn) > 4.094);
}

}  // namespace
}  // namespace headway::hal
