// A bus that keeps what was sent until a test has looked at it, and may have no room.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "hal/can_bus.h"

namespace headway::fuzz {

class HeardBus final : public hal::CanBus {
 public:
  bool send(const hal::CanFrame& frame) noexcept override {
    if (full) return false;
    sent.push_back(frame);
    return true;
  }
  std::size_t receive(std::span<hal::CanFrame>) noexcept override { return 0; }
  hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }

  std::vector<hal::CanFrame> sent;
  bool full = false;
};

}  // namespace headway::fuzz
