// Points in time and durations. Every stamp in the program is monotonic nanoseconds of one clock.
#pragma once

#include <chrono>

namespace headway {

using Duration = std::chrono::nanoseconds;

/// Names the time line of hal::Clock; never read directly.
struct MonotonicTimeline {
  using duration = Duration;
  using rep = Duration::rep;
  using period = Duration::period;
  static constexpr bool is_steady = true;
};

/// A stamp: nanoseconds since the clock's epoch (boot on a robot, zero in simulation).
using Time = std::chrono::time_point<MonotonicTimeline, Duration>;

/// Seconds to the nearest nanosecond.
constexpr Duration seconds(double s) {
  return Duration(static_cast<Duration::rep>(s * 1e9 + (s >= 0 ? 0.5 : -0.5)));
}
constexpr double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }
constexpr double to_seconds(Time t) { return to_seconds(t.time_since_epoch()); }
constexpr Time at_seconds(double s) { return Time(seconds(s)); }

}  // namespace headway
