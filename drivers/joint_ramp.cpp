#include "drivers/joint_ramp.h"

#include <algorithm>
#include <cmath>

namespace headway::drivers {

JointRamp::JointRamp(const Limits& limits) noexcept
    : fastest_(limits.velocity * limits.period),
      change_(limits.acceleration * limits.period * limits.period) {}

void JointRamp::stand(double position) noexcept {
  end_ = position;
  velocity_ = 0;
  part_ = 1;
}

void JointRamp::step_towards(double target, double part) noexcept {
  if (goes_on(part)) return;
  const double way = target - end_, distance = std::abs(way);
  // Braking by b a step, from n b to rest, takes n (n + 1) / 2 steps' b. The last step brakes by up to 9/8 b.
  const double b = change_ * 8 / 9;
  const double n = (std::sqrt(1 + 8 * distance / b) - 1) / 2;
  const double fastest = std::min(n > 1 ? n * b : distance, fastest_);
  move(std::copysign(fastest, way));
}

void JointRamp::step_to_rest(double part) noexcept {
  if (!goes_on(part)) move(0);
}

/// True while the step under way lasts; else the next one is to be made.
bool JointRamp::goes_on(double part) noexcept {
  part_ += part;
  if (part_ <= 1) return true;
  part_ -= 1;
  return false;
}

void JointRamp::move(double wanted_velocity) noexcept {
  velocity_ = std::clamp(wanted_velocity, velocity_ - change_, velocity_ + change_);
  end_ += velocity_;
}

}  // namespace headway::drivers
