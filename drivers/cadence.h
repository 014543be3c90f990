// Something done at a fixed rate from within a faster loop.
#pragma once

#include <optional>

#include "hal/time.h"

namespace headway::drivers {

/// Due at once, then every `cycle`, keeping its phase; what is done later than `latest` after it was due
/// begins a new phase, and what was missed is not made up for.
class Cadence {
 public:
  explicit Cadence(Duration cycle) noexcept : Cadence(cycle, cycle) {}
  Cadence(Duration cycle, Duration latest) noexcept : cycle_(cycle), latest_(latest) {}

  bool is_due(Time now) const noexcept { return !next_ || now >= *next_; }
  /// To be called once it is done; until then it stays due.
  void done(Time now) noexcept {
    const bool keeps_phase = next_ && now - *next_ < latest_;
    next_ = (keeps_phase ? *next_ : now) + cycle_;
  }
  /// Until it is due again, once it was done.
  Duration until_due(Time now) const noexcept { return next_ ? *next_ - now : Duration{}; }
  /// Counts the cycle from `now`: for what was done ahead of time.
  void restart(Time now) noexcept { next_ = now + cycle_; }

 private:
  Duration cycle_, latest_;
  std::optional<Time> next_;
};

}  // namespace headway::drivers
