// The wire of USB-CAN adapters of the candleLight kind: control requests and frames, as the Linux kernel's
// drivers/net/can/usb/gs_usb.c speaks them. All numbers are little endian.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/bit_timing.h"
#include "hal/can_bus.h"

namespace headway::drivers::gs_usb {

struct Product {
  std::uint16_t vendor = 0, product = 0;
};
/// The adapters that speak this: candleLight and CANable, candleLight again, CES CANext, ABE CANdebugger.
constexpr std::array<Product, 4> kProducts{
    {{0x1D50, 0x606F}, {0x1209, 0x2323}, {0x1CD2, 0x606F}, {0x16D0, 0x10B8}}};

/// Vendor requests to the interface: bmRequestType 0x41 out, 0xC1 in. wIndex is the interface; wValue the
/// channel, but 1 for kHostFormat and kDeviceConfig.
enum class Request : std::uint8_t {
  kHostFormat = 0,
  kBitTiming = 1,
  kMode = 2,
  kBitTimingLimits = 4,
  kDeviceConfig = 5,
  kTimestamp = 6,
  kState = 14,
};
constexpr std::uint8_t kOut = 0x41, kIn = 0xC1;

/// What an adapter may be able to do, as bits of Capabilities::features.
constexpr std::uint32_t kTimestamps = 1u << 4;  ///< also the mode flag that turns them on
constexpr std::uint32_t kTellsState = 1u << 13;

/// Answer to kDeviceConfig.
struct DeviceConfig {
  static constexpr std::size_t kSize = 12;
  unsigned channels = 0;
  std::uint32_t firmware = 0, hardware = 0;

  static DeviceConfig unpack(std::span<const std::uint8_t, kSize> bytes) noexcept;
};

/// Answer to kBitTimingLimits.
struct Capabilities {
  static constexpr std::size_t kSize = 40;
  std::uint32_t features = 0;
  std::uint32_t clock_hz = 0;
  BitTimingLimits limits;

  static Capabilities unpack(std::span<const std::uint8_t, kSize> bytes) noexcept;
};

/// What a controller says of itself, answering kState or in an error frame.
struct ControllerState {
  static constexpr std::size_t kSize = 12;
  hal::CanBusState state = hal::CanBusState::kErrorActive;
  std::uint8_t transmit_errors = 0, receive_errors = 0;

  bool operator==(const ControllerState&) const = default;
  /// A controller that is stopped or asleep takes part in nothing: bus off.
  static ControllerState unpack(std::span<const std::uint8_t, kSize> bytes) noexcept;
};

std::array<std::uint8_t, 4> pack_host_format() noexcept;
std::array<std::uint8_t, 20> pack(const BitTiming& timing) noexcept;
std::array<std::uint8_t, 8> pack_mode(bool started, std::uint32_t flags) noexcept;
std::uint32_t unpack_timestamp(
    std::span<const std::uint8_t, 4> bytes) noexcept;  ///< [us], wraps after 71.6 min

/// A frame as it travels through the bulk endpoints, one a transfer.
struct HostFrame {
  static constexpr std::size_t kSize = 20, kSizeWithTimestamp = 24;
  static constexpr std::uint32_t kReceived =
      0xFFFFFFFF;  ///< as echo_id; any other belongs to a frame that was sent
  static constexpr std::uint32_t kExtended = 0x80000000, kRemote = 0x40000000, kError = 0x20000000;
  static constexpr std::uint8_t kOverflow = 1;

  std::uint32_t echo_id = kReceived;
  std::uint32_t can_id = 0;  ///< identifier and the three bits above, as in linux/can.h
  std::uint8_t dlc = 0;
  std::uint8_t channel = 0;
  std::uint8_t flags = 0;
  std::array<std::uint8_t, 8> data{};
  std::optional<std::uint32_t> timestamp_us;  ///< when it was on the bus, by the adapter's clock

  bool operator==(const HostFrame&) const = default;
  bool is_error() const noexcept { return (can_id & kError) != 0; }
  /// The adapter had no room for frames that came before this one.
  bool tells_of_losses() const noexcept;
  /// The frame without its time; nothing when it is no data frame with an 11-bit identifier.
  std::optional<hal::CanFrame> can_frame() const noexcept;
  /// What an error frame (linux/can/error.h) says, starting from what was known before.
  ControllerState controller_state(const ControllerState& before) const noexcept;

  std::array<std::uint8_t, kSize> pack() const noexcept;
  /// Nothing when the bytes are too few or too many for one frame.
  static std::optional<HostFrame> unpack(std::span<const std::uint8_t> bytes) noexcept;
};

}  // namespace headway::drivers::gs_usb
