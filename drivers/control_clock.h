// How far the control computer's clock is from ours, from frames that tell its time and then travel for a
// while that nobody knows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hal/bus_codec.h"
#include "hal/clock_offset.h"
#include "hal/time.h"

namespace headway::drivers {

struct ControlClockConfig {
  /// From its reading the clock to the stamp on the frame, for the quickest of kReadings frames in a row: the
  /// frames of one cycle that go first (4 ms), and a bus loop's cycle where an adapter does not stamp.
  Duration largest_delay = std::chrono::milliseconds(10);
  double drift = 2e-4;                                 ///< most that two crystals differ (relative)
  Duration timeout = hal::bus::ControlTime::kTimeout;  ///< not heard for so long, it is begun anew
};

/// A frame that says `ms` when it is stamped here tells that
///
///     offset = stamp - ms - delay - rest,
///
/// where `delay` has passed since the clock was read, and `rest` is what whole milliseconds leave out. No
/// frame is there before it was sent, so each gives an upper bound, and the quickest of the last few, whose
/// delay is bounded, the lower one. Older bounds widen by the drift. How long the other frames travel does
/// not matter. Real-time safe.
class ControlClock {
 public:
  static constexpr std::size_t kReadings = 3;

  explicit ControlClock(const ControlClockConfig& config = {}) noexcept : config_(config) {}

  /// A clock that went back, or forward by more than the time-out, has been started anew: what was known of
  /// it is forgotten.
  void hear(std::uint32_t ms, Time stamp) noexcept;

  /// Nothing until kReadings frames were heard, nor when none was for the time-out. Its milliseconds are
  /// counted on through their wraps, from the first one heard.
  std::optional<hal::ClockOffset> offset(Time now) const noexcept;

  /// Heard within the time-out.
  bool is_heard(Time now) const noexcept;

 private:
  bool goes_on(std::uint32_t ms, Time stamp) const noexcept;

  struct Reading {
    Time stamp{};
    Duration apart{};  ///< stamp - ms
  };
  const Reading& newest() const noexcept { return readings_[(count_ - 1) % kReadings]; }

  ControlClockConfig config_;
  std::array<Reading, kReadings> readings_{};
  std::size_t count_ = 0;  ///< heard since it was begun
  std::uint32_t ms_ = 0;   ///< the newest
  std::int64_t counted_ms_ = 0;
};

}  // namespace headway::drivers
