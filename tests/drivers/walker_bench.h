// The step master and a scripted control computer on a scripted bus, stepped like the bus loop.
#pragma once

#include <functional>

#include "drivers/can_walker.h"
#include "tests/drivers/scripted_bus.h"
#include "tests/drivers/scripted_control.h"

namespace headway::drivers::testing {

inline hal::Footstep step_of(std::uint32_t index) {
  const auto foot = index % 2 == 0 ? hal::Foot::kLeft : hal::Foot::kRight;
  const double side = foot == hal::Foot::kLeft ? 1 : -1;
  return hal::quantised({foot, {0.001 * (index % 200), side * 0.19, 0.002 * (index % 20)}, 0, seconds(0.8)});
}

class WalkerBench {
 public:
  ScriptedBus bus;
  CanWalker walker{bus};
  ScriptedControl control;
  Time now = at_seconds(50);
  /// What the bus does to a frame: false loses it.
  std::function<bool(hal::CanFrame&)> to_walker = [](hal::CanFrame&) { return true; };
  std::function<bool(hal::CanFrame&)> to_control = [](hal::CanFrame&) { return true; };

  void cycle() {
    now += kBusCycle;
    bus.now = now;
    control.tick(now);
    for (hal::CanFrame& frame : control.out) {
      if (to_walker(frame)) walker.receive(frame);
    }
    control.out.clear();
    const std::size_t before = bus.sent.size();
    walker.tick(now);
    for (std::size_t i = before; i < bus.sent.size(); ++i) {
      hal::CanFrame frame = bus.sent[i];
      if (to_control(frame)) control.receive(frame, now);
    }
  }
  void run(Duration d) {
    for (const Time end = now + d; now < end;) cycle();
  }
  bool run_until(const std::function<bool()>& done, Duration limit) {
    for (const Time end = now + limit; now < end && !done();) cycle();
    return done();
  }
  /// Until the control computer has taken the session up.
  bool begin(std::uint8_t session) {
    walker.control(hal::WalkRequest::kWalk, session, seconds(0.1));
    return run_until([&] { return walker.status().session == session; }, seconds(1));
  }
  bool send(std::uint8_t session, std::uint32_t index) {
    return walker.send(session, {index, step_of(index)});
  }
};

}  // namespace headway::drivers::testing
