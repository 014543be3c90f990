// One step of the robot, in the units that travel on the bus, and the stance it leads to.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "hal/pose2.h"
#include "hal/time.h"

namespace headway::hal {

enum class Foot : std::uint8_t { kLeft = 0, kRight = 1 };
constexpr Foot other(Foot f) { return f == Foot::kLeft ? Foot::kRight : Foot::kLeft; }

/// Where a swinging foot lands, seen from the foot that stands (its x forward, y left).
struct Footstep {
  Foot foot = Foot::kLeft;           ///< the foot that swings
  Pose2 landing;                     ///< support_from_landing [m, rad]
  double dz = 0;                     ///< height of the landing above the standing sole [m]
  Duration duration = seconds(0.8);  ///< lift-off of this step to that of the next (single + double support)
  double clear = 0;  ///< height of what the swinging sole goes over, above the higher sole; 0: nothing [m]
};

/// The value that the step message of config/can/headway.dbc carries: 1 mm, 2 mrad, 8 mm, 50 ms; what is
/// gone over is rounded up to 20 mm.
/// Plans are made on these, so that what is planned is what is walked.
inline Footstep quantised(const Footstep& s) {
  const auto snap = [](double v, double unit, int lo, int hi) {
    return unit * std::clamp(static_cast<int>(std::lround(v / unit)), lo, hi);
  };
  using std::chrono::milliseconds;
  const auto units = (s.duration + milliseconds(25)) / milliseconds(50);
  return {s.foot,
          {snap(s.landing.x, 1e-3, -512, 511), snap(s.landing.y, 1e-3, -512, 511),
           snap(s.landing.yaw, 2e-3, -128, 127)},
          snap(s.dz, 8e-3, -16, 15),
          milliseconds(50) * std::clamp<std::int64_t>(units, 0, 31),
          0.02 * std::clamp(static_cast<int>(std::ceil(s.clear / 0.02 - 1e-9)), 0, 7)};
}

/// Both feet on the floor, in the odometry frame.
struct Stance {
  Pose2 left, right;

  const Pose2& at(Foot f) const { return f == Foot::kLeft ? left : right; }
  Pose2& at(Foot f) { return f == Foot::kLeft ? left : right; }

  /// The stance after a step has landed.
  Stance after(const Footstep& s) const {
    Stance next = *this;
    next.at(s.foot) = at(other(s.foot)) * s.landing;
    return next;
  }
  /// The base frame: midway between the feet, facing their mean direction.
  Pose2 base() const {
    return {(left.x + right.x) / 2, (left.y + right.y) / 2,
            wrap_angle(right.yaw + wrap_angle(left.yaw - right.yaw) / 2)};
  }
  /// Feet parallel under `base`, `feet_apart` metres from centre to centre.
  static Stance parallel(const Pose2& base, double feet_apart) {
    return {base * Pose2{0, feet_apart / 2, 0}, base * Pose2{0, -feet_apart / 2, 0}};
  }
};

}  // namespace headway::hal
