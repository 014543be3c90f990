// Profile position mode: each set-point is offered with bits 4 and 5 of the controlword, acknowledged by bit
// 12 of the statusword, and withdrawn; the drive makes its own way there.
#pragma once

#include <cstdint>

#include "drivers/set_points.h"
#include "hal/cia402.h"
#include "hal/time.h"

namespace headway::drivers {

/// Real-time safe.
class ProfileSetPoints {
 public:
  static constexpr std::int8_t kMode = hal::cia402::kProfilePosition;

  /// `timeout` for an acknowledgement; the third that is missing in a row is a failure.
  ProfileSetPoints(const PositionLimits& limits, Duration timeout) noexcept
      : limits_(limits), timeout_(timeout) {}

  /// The drive has come to Operation enabled: first it is told to stay where it is.
  void start(std::int32_t position, Time now) noexcept;
  void aim(std::int32_t target) noexcept { wanted_ = limits_.clamped(target); }
  /// Stands as long as `hold`; afterwards it stays there until aimed again.
  void hold(bool hold, std::int32_t position) noexcept;
  void tick(const DriveSight& seen, Time now, double part_until_next_sync) noexcept;

  /// In place of a tick when nothing may be said to the drive: its time to answer does not run.
  void pause(Time now) noexcept { since_ = now; }

  // What the drive is to be told now.
  std::uint16_t bits() const noexcept;
  std::int32_t target() const noexcept { return offered_; }
  void sent() noexcept {}

  /// "Stay where you are" was acknowledged.
  bool is_settled() const noexcept { return !settling_; }
  bool has_timed_out() const noexcept { return timed_out_; }
  bool is_moving(const DriveSight& seen) const noexcept;
  /// The set-point last acknowledged; the position until there is one.
  std::int32_t accepted() const noexcept { return accepted_; }

 private:
  enum class Handshake : std::uint8_t { kIdle, kOffered, kWithdrawing };

  void stay(std::int32_t position) noexcept;
  void await_acknowledgement(bool acknowledged, Time now) noexcept;

  PositionLimits limits_;
  Duration timeout_;
  Handshake handshake_ = Handshake::kIdle;
  Time since_{};          ///< when the handshake came to where it is
  bool settling_ = true;  ///< the set-point "where it is" has not been acknowledged yet
  bool held_ = false, timed_out_ = false;
  int unanswered_ = 0;  ///< offers in a row
  std::int32_t wanted_ = 0, offered_ = 0, accepted_ = 0;
};

}  // namespace headway::drivers
