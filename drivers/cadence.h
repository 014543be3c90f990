// Something done at a fixed rate from within a faster loop.
#pragma once

#include <optional>

#include "hal/time.h"

namespace headway::drivers {

/// Due at once, then every `cycle`, keeping its phase; periods missed altogether are skipped, not made up
/// for.
class Cadence {
 public:
  explicit Cadence(Duration cycle) noexcept : cycle_(cycle) {}

  bool is_due(Time now) const noexcept { return !next_ || now >= *next_; }
  /// To be called once it is done; until then it stays due.
  void done(Time now) noexcept {
    next_ = next_ ? *next_ + cycle_ : now + cycle_;
    if (*next_ <= now) next_ = now + cycle_;
  }
  /// Counts the cycle from `now`: for what was done ahead of time.
  void restart(Time now) noexcept { next_ = now + cycle_; }

 private:
  Duration cycle_;
  std::optional<Time> next_;
};

}  // namespace headway::drivers
