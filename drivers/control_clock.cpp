#include "drivers/control_clock.h"

#include <algorithm>

namespace headway::drivers {

namespace {
constexpr Duration kTick = std::chrono::milliseconds(1);
}

void ControlClock::hear(std::uint32_t ms, Time stamp) noexcept {
  if (!goes_on(ms, stamp)) {
    count_ = 0;
    counted_ms_ = 0;
    ms_ = 0;
  }
  counted_ms_ += ms - ms_;  // modulo 2^32: sees through a wrap
  ms_ = ms;
  const Duration shown = std::chrono::milliseconds(counted_ms_);
  readings_[count_++ % kReadings] = {stamp, stamp.time_since_epoch() - shown};
}

bool ControlClock::goes_on(std::uint32_t ms, Time stamp) const noexcept {
  if (!is_heard(stamp) || ms == ms_) return false;
  // A clock that went back looks as if it had run almost once round.
  const Duration since = std::chrono::milliseconds(ms - ms_);
  return since <= stamp - newest().stamp + config_.timeout;
}

std::optional<hal::ClockOffset> ControlClock::offset(Time now) const noexcept {
  if (count_ < kReadings || !is_heard(now)) return std::nullopt;
  Duration low = Duration::max(), high = Duration::max();
  for (const Reading& r : readings_) {
    const Duration drifted = seconds(config_.drift * to_seconds(now - r.stamp));
    low = std::min(low, r.apart - drifted);
    high = std::min(high, r.apart + drifted);
  }
  low -= config_.largest_delay + kTick;
  return hal::ClockOffset{.offset = low + (high - low) / 2, .uncertainty = (high - low) / 2};
}

bool ControlClock::is_heard(Time now) const noexcept {
  return count_ > 0 && now - newest().stamp <= config_.timeout;
}

}  // namespace headway::drivers
