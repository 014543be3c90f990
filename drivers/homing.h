// Whether a drive knows where its joint is, and how it finds that out where it may (CiA 402 homing mode).
#pragma once

#include <cstdint>
#include <optional>

#include "hal/time.h"

namespace headway::drivers {

/// In the drive's own units: 0.001 degree and seconds.
struct HomingNumbers {
  bool may_move = false;           ///< else a drive that does not know is refused
  std::int8_t method = 0;          ///< object 0x6098
  std::uint32_t search_speed = 0;  ///< for the switch
  std::uint32_t zero_speed = 0;    ///< for the zero
  std::uint32_t acceleration = 0;
  Duration longest{};  ///< that it may take; the drive's silence counts
  bool operator==(const HomingNumbers&) const = default;
};

/// Of one drive. Real-time safe.
class Homing {
 public:
  enum class Status : std::uint8_t { kAsked, kMoving, kDone, kNotHomed, kFailed };

  /// Without numbers the drive is taken to know where it is.
  explicit Homing(const std::optional<HomingNumbers>& numbers) noexcept : numbers_(numbers) {
    permit();
    begin();
  }

  /// Somebody has started the head, or recovered it: it may look for home once, if its numbers say so. One
  /// that loses its home later must not swing about while the robot walks.
  void permit() noexcept { may_move_ = numbers_ && numbers_->may_move; }
  /// The drive has been switched on, or interrupted: what it knows is asked anew.
  void begin() noexcept { status_ = numbers_ ? Status::kAsked : Status::kDone; }
  /// The drive is in homing mode, in Operation enabled, and says this, or nothing while it is silent. Time in
  /// which it is `paused` for the other drive's sake is not its own.
  void tick(std::optional<std::uint16_t> statusword, bool paused, Time now) noexcept;

  Status status() const noexcept { return status_; }
  bool is_done() const noexcept { return status_ == Status::kDone; }
  /// Of the controlword.
  std::uint16_t bits() const noexcept;

 private:
  std::optional<HomingNumbers> numbers_;
  Status status_ = Status::kDone;
  bool may_move_ = false;
  Duration spent_{};  ///< on moving
  Time ticked_{};
};

}  // namespace headway::drivers
