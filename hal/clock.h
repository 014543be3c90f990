// Where time comes from: the machine's monotonic clock, or one that a test or the simulator moves by hand.
#pragma once

#include <atomic>

#include "hal/time.h"

namespace headway::hal {

class Clock {
 public:
  virtual ~Clock() = default;
  virtual Time now() const noexcept = 0;
  /// Returns at `t` or, if that has passed, at once.
  virtual void sleep_until(Time t) noexcept = 0;
  /// What this clock showed when CLOCK_MONOTONIC showed `stamp`: for the stamps that the kernel gives.
  virtual Time at_monotonic(Time stamp) const noexcept { return stamp; }
};

/// CLOCK_MONOTONIC; sleeps by absolute time, so a loop keeps its phase.
class MonotonicClock final : public Clock {
 public:
  Time now() const noexcept override;
  void sleep_until(Time t) noexcept override;
};

/// The machine's monotonic clock made slower, alike in all processes of the machine: for one that is too slow
/// for the real thing, such as an emulated one, or in tests too fast.
class ScaledClock final : public Clock {
 public:
  /// A second of it lasts `slower` seconds, which is positive.
  explicit ScaledClock(double slower) : slower_(slower) {}
  Time now() const noexcept override { return at_monotonic(machine_.now()); }
  void sleep_until(Time t) noexcept override;
  Time at_monotonic(Time stamp) const noexcept override;

 private:
  MonotonicClock machine_;
  double slower_;
};

/// Stands still until moved. sleep_until() moves it, so single-threaded lockstep runs as fast as it computes.
class ManualClock final : public Clock {
 public:
  Time now() const noexcept override { return Time(Duration(now_.load(std::memory_order_acquire))); }
  void sleep_until(Time t) noexcept override {
    if (t > now()) set(t);
  }
  void set(Time t) noexcept { now_.store(t.time_since_epoch().count(), std::memory_order_release); }
  void advance(Duration d) noexcept { set(now() + d); }

 private:
  std::atomic<Duration::rep> now_{0};
};

}  // namespace headway::hal
