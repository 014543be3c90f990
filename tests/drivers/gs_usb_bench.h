// A GsUsbBus on one scripted adapter, and what tests of it do over and over.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/gs_usb_bus.h"
#include "hal/clock.h"
#include "tests/drivers/scripted_adapter.h"
#include "tests/drivers/scripted_usb.h"

namespace headway::drivers::testing {

class GsUsbBench : public ::testing::Test {
 protected:
  GsUsbBench() {
    clock.set(at_seconds(1000));
    usb.plug(adapter);
  }
  ~GsUsbBench() override {
    bus.reset();
    EXPECT_EQ(usb.held(), ScriptedUsb::Held{}) << "something was not given back";
    EXPECT_FALSE(adapter.seen.is_started && !adapter.seen.requests.empty() && !was_unplugged);
  }

  void open(const GsUsbConfig& config = {.serial = "0031"}) {
    bus = std::make_unique<GsUsbBus>(config, clock, usb);
  }
  void serve(double s = 0.005) { bus->serve(seconds(s)); }
  void unplug() {
    was_unplugged = true;
    usb.unplug(adapter);
  }
  std::vector<hal::CanFrame> received() {
    std::vector<hal::CanFrame> all;
    std::array<hal::CanFrame, 64> some;
    while (const std::size_t n = bus->receive(some)) all.insert(all.end(), some.begin(), some.begin() + n);
    return all;
  }
  static hal::CanFrame frame(std::uint32_t id, std::uint8_t first_byte = 0) {
    return {.id = id, .dlc = 8, .data = {first_byte}, .stamp = {}};
  }
  /// A frame goes out, is on the bus, and one comes in.
  bool works() {
    const std::uint64_t sent = bus->stats().sent;
    if (!bus->send(frame(0x123))) return false;
    received();
    adapter.replies = false;
    adapter.receive(0x321);
    serve();
    return bus->stats().sent > sent && received().size() == 1;
  }

  hal::ManualClock clock;
  ScriptedUsb usb{clock};
  ScriptedAdapter adapter{clock};
  std::unique_ptr<GsUsbBus> bus;
  bool was_unplugged = false;
};

}  // namespace headway::drivers::testing
