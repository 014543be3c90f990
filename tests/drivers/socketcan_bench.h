// A SocketCAN bus on a scripted kernel and a clock that a test moves.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/socketcan_bus.h"
#include "tests/drivers/scripted_can_kernel.h"

namespace headway::drivers::testing {

/// A bus on can0 of a scripted kernel, some time after boot and at a likely date.
struct SocketCanBench {
  explicit SocketCanBench(SocketCanConfig with = {}) : config(std::move(with)) {
    clock.set(at_seconds(1000));
    kernel.wall_ahead = std::chrono::seconds(1'780'000'000);
  }
  SocketCanBus& bus() {
    if (!bus_) bus_.emplace(config, clock, kernel);
    return *bus_;
  }
  std::vector<hal::CanFrame> received(std::size_t most = 1000) {
    std::vector<hal::CanFrame> frames(most);
    frames.resize(bus().receive(frames));
    return frames;
  }
  /// What the controller says in an error frame.
  void report(canid_t what, std::uint8_t controller = 0, std::uint8_t sent_errors = 0,
              std::uint8_t heard_errors = 0) {
    kernel.arrive(CAN_ERR_FLAG | what, {0, controller, 0, 0, 0, 0, sent_errors, heard_errors});
    received();
  }

  hal::ManualClock clock;
  ScriptedCanKernel kernel{clock};
  SocketCanConfig config;

 private:
  std::optional<SocketCanBus> bus_;
};

inline constexpr hal::CanFrame kFrame{.id = 0x123, .dlc = 2, .data = {1, 2}};

}  // namespace headway::drivers::testing
