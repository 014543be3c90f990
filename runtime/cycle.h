// A loop that goes round at fixed times: when the next round is due, how late rounds begin and how long they
// take, and whether so many are missed that the robot must come to rest.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "hal/time.h"
#include "runtime/histogram.h"

namespace headway::runtime {

/// How many missed cycles are borne. The control computer brings the robot to rest by itself after 150 ms
/// without a word from the bus loop (WalkControl, docs/bus.md): 20 cycles of 5 ms are 100 ms, so that the
/// program still ends the walk by its own stop. Fewer cost nothing: steps are handed over 150 ms ahead.
struct CycleLimits {
  int most_missed = 20;  ///< within `within`; at most Cycle::kMostRemembered
  Duration within = seconds(1.0);

  /// Throws InputError.
  void validate() const;
};

enum class CycleHealth : std::uint8_t {
  kOnTime,   ///< none was missed lately, or few: a quarter of what is borne
  kLate,     ///< more were, no more than is borne: no walk begins
  kFailing,  ///< more were
};
const char* name(CycleHealth health);

/// A cycle is missed when its whole period passes without a round that begins; those after it keep their
/// times. begin() and end() belong to the loop's thread and are real-time safe; the rest may be asked by any.
class Cycle {
 public:
  static constexpr int kMostRemembered = 255;

  /// The first round is due when it begins. Throws InputError as CycleLimits::validate.
  Cycle(Duration period, const CycleLimits& limits);

  /// When the next round is due, the first at once: for the loop's thread.
  Time due() const noexcept { return due_; }
  /// A round begins at `now`, the one that is due or, if that is missed, a later one.
  CycleHealth begin(Time now) noexcept;
  /// Its work is done.
  void end(Time now) noexcept { run_time_.add(now - begun_); }

  CycleHealth health() const noexcept { return health_.load(std::memory_order_relaxed); }
  std::uint64_t missed() const noexcept { return missed_.load(std::memory_order_relaxed); }
  const Histogram& wake_up_delay() const noexcept { return wake_up_delay_; }  ///< from due() to begin()
  const Histogram& run_time() const noexcept { return run_time_; }            ///< from begin() to end()

 private:
  static constexpr int kFew = 4;  ///< one part in so many of what is borne
  void miss(std::int64_t count) noexcept;
  CycleHealth judge(Time now) const noexcept;

  Duration period_;
  CycleLimits limits_;
  bool first_ = true;
  Time due_{}, begun_{};
  /// When the newest missed cycles were due: number n at n modulo the size.
  std::array<Time, kMostRemembered + 1> missed_at_{};
  std::atomic<std::uint64_t> missed_{0};
  std::atomic<CycleHealth> health_{CycleHealth::kOnTime};
  Histogram wake_up_delay_, run_time_;
};

}  // namespace headway::runtime
