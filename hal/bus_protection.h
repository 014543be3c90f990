// A counter and a CRC in the first two bytes of a message: AUTOSAR E2E profile 11, variant A, as
// config/can/headway.dbc lays it out (Crc 0|8, Counter 8|4). The receiver tells which frames may be used.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "hal/can_bus.h"

namespace headway::hal::bus {

/// CRC-8 with polynomial 0x1D, initial value 0, no final xor: "123456789" gives 0x37.
constexpr std::uint8_t crc8(std::span<const std::uint8_t> bytes, std::uint8_t crc = 0) noexcept {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint8_t>(crc ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint8_t>((crc & 0x80) != 0 ? (crc << 1) ^ 0x1D : crc << 1);
    }
  }
  return crc;
}

/// The CRC that belongs into byte 0: over the data id's low and high byte, then bytes 1 to dlc - 1.
std::uint8_t frame_crc(const CanFrame& frame, std::uint16_t data_id) noexcept;

/// Counts and signs the frames of one message on their way out.
class Protector {
 public:
  explicit Protector(std::uint16_t data_id) noexcept : data_id_(data_id) {}
  /// Writes the next counter (0, 1, ... 14, 0, ...) and the CRC into the frame. Call it for frames that are
  /// sent: each repetition gets a counter of its own.
  void protect(CanFrame& frame) noexcept;

 private:
  std::uint16_t data_id_;
  std::uint8_t counter_ = 0;
};

enum class Check : std::uint8_t {
  kOk,             ///< the first frame, or the next
  kOkSomeLost,     ///< good, a few before it were lost
  kWrongCrc,       ///< damaged, or another message
  kRepeated,       ///< the same counter as before
  kWrongSequence,  ///< too many lost, or an old one; the next is measured against it
};
constexpr bool is_usable(Check c) { return c == Check::kOk || c == Check::kOkSomeLost; }

/// Judges the frames of one message as they come in.
class ProtectionChecker {
 public:
  /// How many of each verdict there were; `lost` counts frames missing before an accepted one.
  struct Counts {
    std::uint32_t ok = 0, wrong_crc = 0, repeated = 0, wrong_sequence = 0, lost = 0;
  };

  /// A step of the counter up to `max_delta` (1..14) is taken.
  explicit ProtectionChecker(std::uint16_t data_id, int max_delta = 5) noexcept
      : data_id_(data_id), max_delta_(max_delta) {}

  /// Only a usable frame may be read (is_usable).
  [[nodiscard]] Check check(const CanFrame& frame) noexcept;
  const Counts& counts() const noexcept { return counts_; }

 private:
  std::uint16_t data_id_;
  int max_delta_;
  std::optional<std::uint8_t> last_;
  Counts counts_;
};

}  // namespace headway::hal::bus
