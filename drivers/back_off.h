// When to try again to reach a device that went away: soon at first, then ever less often.
#pragma once

#include <algorithm>

#include "hal/time.h"

namespace headway::drivers {

/// How long to wait before each try.
struct BackOffConfig {
  Duration first = std::chrono::milliseconds(500);
  Duration longest = std::chrono::seconds(5);
};

/// Waits `first`, then twice as long after each failure, up to `longest`.
class BackOff {
 public:
  explicit BackOff(const BackOffConfig& config = {}) noexcept : config_(config), wait_(config.first) {}

  /// The device is gone.
  void begin(Time now) noexcept {
    wait_ = config_.first;
    next_ = now + wait_;
  }
  bool is_due(Time now) const noexcept { return now >= next_; }
  /// A try did not reach it.
  void failed(Time now) noexcept {
    wait_ = std::min(2 * wait_, config_.longest);
    next_ = now + wait_;
  }
  /// When the next try is due.
  Time next() const noexcept { return next_; }

 private:
  BackOffConfig config_;
  Duration wait_;
  Time next_{};
};

}  // namespace headway::drivers
