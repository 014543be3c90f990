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

/// Of the robot's bus (docs/bus.md) [bit/s].
inline constexpr int kCanBitRate = 500'000;

enum class CanBusState : std::uint8_t { kErrorActive, kErrorWarning, kErrorPassive, kBusOff, kGone };

constexpr const char* text_of(CanBusState state) {
  switch (state) {
    case CanBusState::kErrorActive:
      return "error active";
    case CanBusState::kErrorWarning:
      return "error warning";
    case CanBusState::kErrorPassive:
      return "error passive";
    case CanBusState::kBusOff:
      return "off the bus";
    case CanBusState::kGone:
      return "gone";
  }
  return "unknown";
}

/// What a bus has seen since the program began. All counts only grow.
struct CanBusStats {
  CanBusState state = CanBusState::kErrorActive;
  std::uint8_t transmit_errors = 0, receive_errors = 0;  ///< the controller's counters, where it tells them
  std::uint64_t sent = 0, received = 0;                  ///< data frames
  std::uint64_t refused = 0;                             ///< send() found no room, or no bus
  std::uint64_t lost = 0;                                ///< received frames that nobody took in time
  std::uint64_t unusable = 0;  ///< what came and was no data frame with an 11-bit identifier
  std::uint64_t bus_off = 0;   ///< times it went off the bus
  std::uint64_t gone = 0;      ///< times the adapter or the interface went away
};

/// Real-time safe: no call blocks, allocates or throws.
class CanBus {
 public:
  virtual ~CanBus() = default;
  /// Queues a frame. False when there is no room; the caller decides whether it is worth sending later.
  virtual bool send(const CanFrame& frame) noexcept = 0;
  /// Fills `into` from the front with frames received since the last call; returns how many.
  virtual std::size_t receive(std::span<CanFrame> into) noexcept = 0;
  virtual CanBusState state() const noexcept = 0;
  virtual CanBusStats stats() const noexcept { return {.state = state()}; }
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
