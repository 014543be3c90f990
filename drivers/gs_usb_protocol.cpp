#include "drivers/gs_usb_protocol.h"

#include <algorithm>

namespace headway::drivers::gs_usb {

namespace {

std::uint32_t number_at(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
  std::uint32_t n = 0;
  for (std::size_t i = 4; i-- > 0;) n = n << 8 | bytes[at + i];
  return n;
}

void put_number(std::span<std::uint8_t> bytes, std::size_t at, std::uint32_t n) noexcept {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(n >> (8 * i));
}

/// Error counters are of 8 bits in CAN; at 256 the controller is off the bus.
std::uint8_t counter(std::uint32_t n) noexcept { return static_cast<std::uint8_t>(std::min(n, 255u)); }

// Classes of error frames (bits of can_id), and what their data[1] says of the controller: linux/can/error.h.
constexpr std::uint32_t kController = 0x04, kBusOff = 0x40, kRestarted = 0x100, kCounters = 0x200;
constexpr std::uint8_t kWarning = 0x04 | 0x08, kPassive = 0x10 | 0x20, kActive = 0x40,
                       kReceiveOverflow = 0x01;

}  // namespace

DeviceConfig DeviceConfig::unpack(std::span<const std::uint8_t, kSize> bytes) noexcept {
  return {.channels = bytes[3] + 1u, .firmware = number_at(bytes, 4), .hardware = number_at(bytes, 8)};
}

Capabilities Capabilities::unpack(std::span<const std::uint8_t, kSize> bytes) noexcept {
  return {.features = number_at(bytes, 0),
          .clock_hz = number_at(bytes, 4),
          .limits = {.tseg1_min = number_at(bytes, 8),
                     .tseg1_max = number_at(bytes, 12),
                     .tseg2_min = number_at(bytes, 16),
                     .tseg2_max = number_at(bytes, 20),
                     .sjw_max = number_at(bytes, 24),
                     .brp_min = number_at(bytes, 28),
                     .brp_max = number_at(bytes, 32),
                     .brp_increment = number_at(bytes, 36)}};
}

ControllerState ControllerState::unpack(std::span<const std::uint8_t, kSize> bytes) noexcept {
  using enum hal::CanBusState;
  constexpr std::array kStates{kErrorActive, kErrorWarning, kErrorPassive, kBusOff};
  const std::uint32_t state = number_at(bytes, 0);
  return {.state = kStates[std::min<std::size_t>(state, kStates.size() - 1)],
          .transmit_errors = counter(number_at(bytes, 8)),
          .receive_errors = counter(number_at(bytes, 4))};
}

std::array<std::uint8_t, 4> pack_host_format() noexcept {
  std::array<std::uint8_t, 4> bytes;
  put_number(bytes, 0, 0x0000BEEF);
  return bytes;
}

std::array<std::uint8_t, 20> pack(const BitTiming& timing) noexcept {
  std::array<std::uint8_t, 20> bytes;
  put_number(bytes, 0, timing.prop_seg);
  put_number(bytes, 4, timing.phase_seg1);
  put_number(bytes, 8, timing.phase_seg2);
  put_number(bytes, 12, timing.sjw);
  put_number(bytes, 16, timing.brp);
  return bytes;
}

std::array<std::uint8_t, 8> pack_mode(bool started, std::uint32_t flags) noexcept {
  std::array<std::uint8_t, 8> bytes;
  put_number(bytes, 0, started ? 1 : 0);
  put_number(bytes, 4, flags);
  return bytes;
}

std::uint32_t unpack_timestamp(std::span<const std::uint8_t, 4> bytes) noexcept {
  return number_at(bytes, 0);
}

std::optional<hal::CanFrame> HostFrame::can_frame() const noexcept {
  if ((can_id & (kExtended | kRemote | kError)) != 0 || can_id > 0x7FF) return std::nullopt;
  // On a classic bus a length code above 8 still means 8 bytes, and adapters hand it on as it came.
  return hal::CanFrame{.id = can_id, .dlc = std::min<std::uint8_t>(dlc, 8), .data = data, .stamp = {}};
}

bool HostFrame::tells_of_losses() const noexcept {
  const bool is_of_controller = is_error() && (can_id & kController) != 0;
  return (flags & kOverflow) != 0 || (is_of_controller && (data[1] & kReceiveOverflow) != 0);
}

ControllerState HostFrame::controller_state(const ControllerState& before) const noexcept {
  using enum hal::CanBusState;
  ControllerState now = before;
  if ((can_id & gs_usb::kBusOff) != 0) {
    now.state = hal::CanBusState::kBusOff;
  } else if ((can_id & kRestarted) != 0) {
    now.state = kErrorActive;
  } else if ((can_id & kController) != 0) {
    if ((data[1] & kPassive) != 0) {
      now.state = kErrorPassive;
    } else if ((data[1] & kWarning) != 0) {
      now.state = kErrorWarning;
    } else if ((data[1] & kActive) != 0 || data[1] == 0) {
      now.state = kErrorActive;
    }
  }
  // Firmware older than the class of counters fills them in with the controller's states.
  if ((can_id & (kCounters | kController)) != 0) {
    now.transmit_errors = data[6];
    now.receive_errors = data[7];
  }
  return now;
}

std::array<std::uint8_t, HostFrame::kSize> HostFrame::pack() const noexcept {
  std::array<std::uint8_t, kSize> bytes{};
  put_number(bytes, 0, echo_id);
  put_number(bytes, 4, can_id);
  bytes[8] = dlc;
  bytes[9] = channel;
  bytes[10] = flags;
  std::copy(data.begin(), data.end(), bytes.begin() + 12);
  return bytes;
}

std::optional<HostFrame> HostFrame::unpack(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() != kSize && bytes.size() != kSizeWithTimestamp) return std::nullopt;
  HostFrame f{.echo_id = number_at(bytes, 0),
              .can_id = number_at(bytes, 4),
              .dlc = bytes[8],
              .channel = bytes[9],
              .flags = bytes[10],
              .data = {},
              .timestamp_us = {}};
  std::copy_n(bytes.begin() + 12, f.data.size(), f.data.begin());
  if (bytes.size() == kSizeWithTimestamp) f.timestamp_us = number_at(bytes, kSize);
  return f;
}

}  // namespace headway::drivers::gs_usb
