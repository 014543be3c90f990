// Reads a text (VISIBLE_STRING) from one CANopen node, such as its name: an SDO upload, at once or in
// segments (CiA 301, 7.2.4.3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/sdo_client.h"
#include "hal/can_bus.h"
#include "hal/time.h"

namespace headway::drivers {

/// Real-time safe. read(), then tick() and receive() until it is no longer busy. Not beside an SdoClient that
/// is busy with the same node.
class SdoText {
 public:
  using Status = SdoClient::Status;
  /// More than this is left out.
  static constexpr std::size_t kMost = 64;

  SdoText(hal::CanBus& bus, std::uint8_t node, const SdoClient::Config& config = {}) noexcept
      : bus_(bus), node_(node), config_(config) {}

  /// Of the object with this index, subindex 0.
  void read(std::uint16_t index) noexcept;
  void receive(const hal::CanFrame& frame) noexcept;
  void tick(Time now) noexcept;

  Status status() const noexcept { return status_; }
  /// Once done: up to the first zero.
  std::string_view text() const noexcept;

 private:
  void take_beginning(const hal::CanFrame& frame) noexcept;
  void take_segment(const hal::CanFrame& frame) noexcept;
  void append(const std::uint8_t* bytes, std::size_t count) noexcept;
  void abort_transfer() noexcept;
  void ask(std::array<std::uint8_t, 8> request) noexcept;

  hal::CanBus& bus_;
  std::uint8_t node_;
  SdoClient::Config config_;
  Status status_ = Status::kIdle;
  std::uint16_t index_ = 0;
  std::array<char, kMost> text_{};
  std::size_t size_ = 0;
  bool in_segments_ = false, toggle_ = false;
  std::array<std::uint8_t, 8> request_{};
  std::optional<Time> sent_;
  int tries_left_ = 0;
};

}  // namespace headway::drivers
