// One classic CAN bus: frames in, frames out, never waiting.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/time.h"

namespace headway::hal {

/// A classic data frame with an 11-bit identifier.
struct CanFrame {
  std::uint32_t id = 0;
  std::uint8_t dlc = 0;  ///< 0..8 bytes of data used
  std::array<std::uint8_t, 8> data{};
  Time stamp{};  ///< when it was on the bus (received frames)
};

enum class CanBusState : std::uint8_t { kErrorActive, kErrorWarning, kErrorPassive, kBusOff, kGone };

/// Real-time safe: no call blocks, allocates or throws.
class CanBus {
 public:
  virtual ~CanBus() = default;
  /// Queues a frame. False when there is no room; the caller decides whether it is worth sending later.
  virtual bool send(const CanFrame& frame) noexcept = 0;
  /// Fills `into` from the front with frames received since the last call; returns how many.
  virtual std::size_t receive(std::span<CanFrame> into) noexcept = 0;
  virtual CanBusState state() const noexcept = 0;
};

/// Something that talks on a bus from within the bus loop. The loop hands every received frame to every node,
/// then lets each send: receive()* tick(), once a cycle. Real-time safe: no blocking, heap or exceptions.
class BusNode {
 public:
  virtual ~BusNode() = default;
  virtual void receive(const CanFrame& frame) noexcept = 0;
  virtual void tick(Time now) noexcept = 0;
};

}  // namespace headway::hal
