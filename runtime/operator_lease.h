// The operator's hold on the robot: renewed several times a second, else the robot comes to rest, and later
// it is gone for good.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/time.h"

namespace headway::runtime {

/// What the operator says to the bus loop, in a newest-value slot: no word may be lost, so events are counts.
struct OperatorWord {
  std::uint32_t lease = 0;  ///< number of the lease that holds; 0: nobody has control
  Time renewed{};
  std::uint32_t stops = 0, resets = 0;  ///< asked for since the program began
};

/// Not renewed for kGone, a lease never counts again: the operator must take control anew, under another
/// number. Where nobody ever had control, as when the goal came from the command line, none is needed.
class OperatorLease {
 public:
  static constexpr Duration kGone = seconds(5);

  /// Once a cycle.
  void follow(const OperatorWord& word, Time now) noexcept {
    gone_ = gone_ || (used_ && now - renewed_ > kGone);
    if (word.lease != lease_) {
      lease_ = word.lease;
      gone_ = lease_ == 0;
      used_ = true;
      renewed_ = word.renewed;
    } else if (!gone_ && word.renewed > renewed_) {
      renewed_ = word.renewed;
    }
  }
  /// Somebody has, or had, control.
  bool used() const noexcept { return used_; }
  bool gone() const noexcept { return used_ && gone_; }
  /// When it was renewed last; nothing without a lease that holds.
  std::optional<Time> renewed() const noexcept {
    return used_ && !gone_ ? std::optional(renewed_) : std::nullopt;
  }

 private:
  std::uint32_t lease_ = 0;
  bool used_ = false, gone_ = false;
  Time renewed_{};
};

}  // namespace headway::runtime
