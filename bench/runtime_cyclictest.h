// The yardstick for wake-up delays: cyclictest (rt-tests), which does nothing but wake up; and the load that
// both are measured under (stress-ng).
#pragma once

#include <cstdint>

#include <sys/types.h>

#include "hal/time.h"

namespace headway::bench {

struct WakeUps {
  std::uint64_t count = 0;
  std::uint64_t missed = 0;  ///< later than a whole period
  Duration p50{}, p99{}, p999{}, max{};
};

/// Wakes up each `period` for so long, at this priority of SCHED_FIFO, on this processor, its memory locked
/// and the machine's power management left as it is. Throws Error where cyclictest cannot be run.
WakeUps cyclictest(Duration period, int priority, int processor, Duration length);

/// Work for one processor, as long as it lives.
class Load {
 public:
  /// Throws Error where stress-ng cannot be run.
  explicit Load(int processor);
  ~Load();
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

 private:
  pid_t stress_ = 0;
};

}  // namespace headway::bench
