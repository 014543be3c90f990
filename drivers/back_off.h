// When to try again to reach a device that went away: soon at first, then ever less often.
#pragma once

#include <algorithm>

#include "hal/time.h"

namespace headway::drivers {

/// How long to wait before each try.
struct BackOffConfig {
  Duration first = std::chrono::milliseconds(500);
  Duration longest = std::chrono::seconds(5);

  /// From one millisecond to an hour, and the longest no shorter than the first.
  constexpr bool is_sound() const noexcept {
    return first >= std::chrono::milliseconds(1) && longest >= first && longest <= std::chrono::hours(1);
  }
};

/// Waits `first`, then twice as long after each failure, up to `longest`. One that is back for a moment only
/// has failed as well: its owner says when it works.
class BackOff {
 public:
  explicit BackOff(const BackOffConfig& config = {}) noexcept : config_(config) {}

  /// The device is gone.
  void begin(Time now) noexcept {
    wait_ = config_.first;
    next_ = now + wait_;
  }
  /// The device is gone that worked for long: the first try need not wait.
  void begin_at_once(Time now) noexcept {
    wait_ = Duration::zero();
    next_ = now;
  }
  bool is_due(Time now) const noexcept { return now >= next_; }
  /// A try did not reach it.
  void failed(Time now) noexcept {
    wait_ = std::clamp(2 * wait_, config_.first, config_.longest);
    next_ = now + wait_;
  }
  /// When the next try is due.
  Time next() const noexcept { return next_; }

 private:
  BackOffConfig config_;
  Duration wait_{};
  Time next_{};
};

}  // namespace headway::drivers
