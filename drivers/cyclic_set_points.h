// Cyclic synchronous position mode: a target with every SYNC, and the drive goes there until the next one.
// The way is made here: a drive in this mode does at once what it is told.
#pragma once

#include <cstdint>

#include "drivers/joint_ramp.h"
#include "drivers/set_points.h"
#include "hal/cia402.h"
#include "hal/time.h"

namespace headway::drivers {

/// Real-time safe.
class CyclicSetPoints {
 public:
  static constexpr std::int8_t kMode = hal::cia402::kCyclicPosition;

  /// `timeout` for bit 12 of the statusword, which says that the drive follows.
  CyclicSetPoints(const PositionLimits& limits, const JointRamp::Limits& ramp, Duration timeout) noexcept
      : limits_(limits), ramp_(ramp), next_(ramp), timeout_(timeout) {}

  /// The drive has come to Operation enabled: first it is told to stay where it is. Where that is a little
  /// outside the limits, it goes inside on the ramp.
  void start(std::int32_t position, Time now) noexcept;
  void aim(std::int32_t target) noexcept { wanted_ = limits_.clamped(target); }
  /// Brakes and stands as long as `hold`; afterwards it stays there until aimed again.
  void hold(bool hold, std::int32_t position) noexcept;
  /// Goes on to where the way is at the next SYNC, the given part of a period after the newest one: a drive
  /// that takes a period for each target, from SYNC on, then goes evenly however unsteady SYNC is. While the
  /// drive does not follow, the target is where it stands; while it is silent, the target brakes and stands.
  void tick(const DriveSight& seen, Time now, double part_until_next_sync) noexcept;

  /// In place of a tick when nothing may be said to the drive, which comes to rest at the target it has.
  void pause(Time now) noexcept;

  // What the drive is to be told now.
  std::uint16_t bits() const noexcept { return 0; }
  std::int32_t target() const noexcept;
  /// That target is on its way: the next SYNC has the next one.
  void sent() noexcept { ramp_ = next_; }

  /// The drive has followed since it was started.
  bool is_settled() const noexcept { return settled_; }
  bool has_timed_out() const noexcept { return timed_out_; }
  bool is_moving(const DriveSight& seen) const noexcept;
  /// Where it was last told to end.
  std::int32_t accepted() const noexcept { return wanted_; }

 private:
  void stand(std::int32_t position) noexcept;

  PositionLimits limits_, wire_;  ///< wire_: as far as the joint was outside when it last stood by itself
  JointRamp ramp_, next_;         ///< as sent, and a step further
  Duration timeout_;
  Time followed_{};
  bool settled_ = false, held_ = false, timed_out_ = false;
  std::int32_t wanted_ = 0;
};

}  // namespace headway::drivers
