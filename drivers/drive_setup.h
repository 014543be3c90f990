// Everything a head drive is told before it may move: object by object, written and read back.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/homing.h"
#include "drivers/sdo_client.h"
#include "hal/cia402.h"
#include "hal/time.h"

namespace headway::drivers {

/// Numbers of one drive in its own units: 0.001 degree and seconds.
struct DriveNumbers {
  std::int32_t lower = 0, upper = 0;       ///< software position limits
  std::uint32_t velocity = 0;              ///< profile velocity
  std::uint32_t acceleration = 0;          ///< profile acceleration and deceleration
  std::uint32_t quick_stop = 0;            ///< quick-stop deceleration
  std::uint32_t following_window = 0;      ///< following error that is a fault...
  std::uint16_t following_timeout_ms = 0;  ///< ...when it lasts this long
  bool cyclic = false;                     ///< cyclic synchronous position instead of profile position
  bool may_come_inside = true;             ///< from where it stands outside its limits
  std::optional<HomingNumbers> homing{};   ///< none: the drive knows where it is
  bool operator==(const DriveNumbers&) const = default;
};

struct SetupEntry {
  hal::cia402::Object object;
  std::uint32_t value = 0;
};

/// The entries in their order; no heap. The fullest table fits exactly.
class SetupTable {
 public:
  static constexpr std::size_t kMost = 42;

  constexpr void add(const hal::cia402::Object& object, std::uint32_t value) noexcept {
    assert(count_ < kMost);
    entries_[count_++] = {object, value};
  }
  constexpr std::size_t size() const noexcept { return count_; }
  const SetupEntry& operator[](std::size_t i) const noexcept { return entries_[i]; }

 private:
  std::array<SetupEntry, kMost> entries_{};
  std::size_t count_ = 0;
};

/// The set-up of docs/bus.md in the order it must be written: heartbeats, stop options, profile, then each
/// PDO switched off, mapped and switched on again.
SetupTable setup_table(std::uint8_t node, const DriveNumbers& numbers) noexcept;

/// Works through the table: write, read back, compare, next. Real-time safe.
class DriveSetup {
 public:
  enum class Status : std::uint8_t { kBusy, kDone, kTimedOut, kRefused, kReadsDifferent };

  DriveSetup(CanopenMaster& master, std::uint8_t node, const DriveNumbers& numbers,
             const SdoClient::Config& config) noexcept
      : table_(setup_table(node, numbers)), sdo_(master, node, config) {}

  void begin() noexcept;
  void receive(const hal::CanFrame& frame) noexcept { sdo_.receive(frame); }
  void tick(Time now) noexcept;

  Status status() const noexcept { return status_; }
  /// The object being worked on, or that failed.
  const hal::cia402::Object& object() const noexcept { return sdo_.object(); }
  std::uint32_t abort_code() const noexcept { return sdo_.abort_code(); }

 private:
  void read_back() noexcept;
  void compare() noexcept;

  SetupTable table_;
  SdoClient sdo_;
  std::size_t next_ = 0;
  bool reading_ = false;
  Status status_ = Status::kBusy;
};

}  // namespace headway::drivers
