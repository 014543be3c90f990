// The head: two joints that point the cameras. Pan turns left (about +z), tilt looks down (about +y).
#pragma once

#include <cstdint>

#include "hal/can_bus.h"
#include "hal/time.h"

namespace headway::hal {

/// Joint angles [rad]. Positive pan looks left, positive tilt looks down (REP 103 axes).
struct HeadAngles {
  double pan = 0, tilt = 0;
};

/// What the head can do; commands are clamped to it before the wire.
struct HeadLimits {
  HeadAngles lower{-0.785398, -0.523599}, upper{0.785398, 0.785398};  ///< [rad]
  double velocity = 1.0;                                              ///< profile velocity [rad/s]
  double acceleration = 4.0;                                          ///< profile acceleration [rad/s^2]
};

enum class HeadHealth : std::uint8_t {
  kStarting,  ///< drives are being set up; not moved yet
  kReady,     ///< follows commands
  kDegraded,  ///< a status or position has stayed away; the pose is not known
  kNotHomed,  ///< a drive does not know where its joint is; not moved
  kFault,     ///< a drive reports a fault, is gone, or refused its set-up
};

struct HeadState {
  HeadHealth health = HeadHealth::kStarting;
  HeadAngles position, velocity;  ///< as last reported by both drives [rad, rad/s]
  Time stamp{};                   ///< when that position held
  HeadAngles target;              ///< the set-point last accepted
  bool moving = false;            ///< a drive has not reached its target yet
};

class Head : public BusNode {
 public:
  /// Asks for a new direction; clamped to the limits. Ignored unless ready; the last one wins.
  virtual void command(const HeadAngles& target) noexcept = 0;
  virtual HeadState state() const noexcept = 0;
  /// Somebody has looked at a drive's fault: it is set up anew. Nothing where there is none.
  virtual void recover() noexcept = 0;
};

}  // namespace headway::hal
