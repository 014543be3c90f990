// The head master with two scripted drives on a scripted bus, stepped like the bus loop.
#pragma once

#include <functional>
#include <vector>

#include "drivers/cia402_head.h"
#include "tests/drivers/scripted_bus.h"
#include "tests/drivers/scripted_drive.h"

namespace headway::drivers::testing {

class HeadBench {
 public:
  explicit HeadBench(const HeadConfig& config = {}) : head(bus, config) {}

  ScriptedBus bus;
  Cia402Head head;
  ScriptedDrive pan{0x11}, tilt{0x12};
  Time now = at_seconds(100);
  /// What the bus does to a frame: false loses it.
  std::function<bool(hal::CanFrame&)> to_head = [](hal::CanFrame&) { return true; };
  std::function<bool(hal::CanFrame&)> to_drives = [](hal::CanFrame&) { return true; };

  void cycle() {
    now += kBusCycle;
    bus.now = now;
    for (ScriptedDrive* drive : {&pan, &tilt}) {
      drive->tick(now);
      for (hal::CanFrame& frame : drive->out) {
        if (to_head(frame)) head.receive(frame);
      }
      drive->out.clear();
    }
    const std::size_t before = bus.sent.size();
    head.tick(now);
    for (std::size_t i = before; i < bus.sent.size(); ++i) {
      hal::CanFrame frame = bus.sent[i];
      if (!to_drives(frame)) continue;
      pan.receive(frame, now);
      tilt.receive(frame, now);
    }
  }
  void run(Duration d) {
    for (const Time end = now + d; now < end;) cycle();
  }
  /// Runs until `done`, at most `limit`; whether it came to that.
  bool run_until(const std::function<bool()>& done, Duration limit) {
    for (const Time end = now + limit; now < end && !done();) cycle();
    return done();
  }
  bool run_until(hal::HeadHealth health, Duration limit) {
    return run_until([&] { return head.state().health == health; }, limit);
  }
  bool start() { return run_until(hal::HeadHealth::kReady, seconds(5)); }
};

}  // namespace headway::drivers::testing
