// A bus that a test holds in its hands: it sees every frame sent, and can be full.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "hal/can_bus.h"

namespace headway::drivers::testing {

class ScriptedBus final : public hal::CanBus {
 public:
  ScriptedBus() { sent.reserve(1 << 16); }  // so that recording uses no heap while a test counts

  bool send(const hal::CanFrame& frame) noexcept override {
    if (full || sent.size() == sent.capacity()) return false;
    sent.push_back(frame);
    sent.back().stamp = now;
    return true;
  }
  std::size_t receive(std::span<hal::CanFrame>) noexcept override { return 0; }
  hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }

  /// The frames sent with this id, oldest first.
  std::vector<hal::CanFrame> sent_with(std::uint32_t id) const {
    std::vector<hal::CanFrame> some;
    for (const hal::CanFrame& f : sent) {
      if (f.id == id) some.push_back(f);
    }
    return some;
  }

  std::vector<hal::CanFrame> sent;
  Time now{};
  bool full = false;
};

constexpr Duration kBusCycle = std::chrono::milliseconds(5);

}  // namespace headway::drivers::testing
