// When something happened by this machine's clock, from the microseconds of an adapter that count on their
// own and wrap after 71.6 minutes.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/time.h"

namespace headway::drivers {

/// To be set every few seconds, and at least every 35 minutes. Between, an adapter's crystal may run off by
/// kDrift.
class AdapterClock {
 public:
  static constexpr double kDrift = 2e-4;  ///< most that two crystals differ (relative)

  /// The adapter said `us`, and that was after `asked` and before `answered`. Used when it makes the clock
  /// surer.
  void set(std::uint32_t us, Time asked, Time answered) noexcept {
    const Duration half = (answered - asked) / 2;
    if (reading_ && half >= uncertainty(answered)) return;
    reading_ = Reading{us, asked + half, half};
  }

  /// Nothing before it was set. `us` within 35 minutes of the last setting, before or after.
  std::optional<Time> time(std::uint32_t us) const noexcept {
    if (!reading_) return std::nullopt;
    // Differences modulo 2^32, read as signed, see through a wrap between the two.
    const auto since = static_cast<std::int32_t>(us - reading_->us);
    return reading_->at + std::chrono::microseconds(since);
  }

  /// How far off time() may be at `now`.
  Duration uncertainty(Time now) const noexcept {
    if (!reading_) return Duration::max();
    return reading_->half + seconds(kDrift * to_seconds(now - reading_->at));
  }

 private:
  struct Reading {
    std::uint32_t us = 0;
    Time at{};
    Duration half{};  ///< of the time that asking took
  };
  std::optional<Reading> reading_;
};

}  // namespace headway::drivers
