#include "hal/clock.h"

#include <cerrno>
#include <cmath>
#include <ctime>

namespace headway::hal {

Time MonotonicClock::now() const noexcept {
  timespec ts{};
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return Time(std::chrono::seconds(ts.tv_sec) + Duration(ts.tv_nsec));
}

void MonotonicClock::sleep_until(Time t) noexcept {
  const auto ns = t.time_since_epoch().count();
  const timespec until{ns / 1'000'000'000, ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

Time ScaledClock::at_monotonic(Time stamp) const noexcept {
  return Time(
      Duration(static_cast<Duration::rep>(static_cast<double>(stamp.time_since_epoch().count()) / slower_)));
}

void ScaledClock::sleep_until(Time t) noexcept {
  const auto ns = std::ceil(static_cast<double>(t.time_since_epoch().count()) * slower_);
  machine_.sleep_until(Time(Duration(static_cast<Duration::rep>(ns))));
}

}  // namespace headway::hal
