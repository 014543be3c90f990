#include "drivers/cyclic_set_points.h"

#include <cmath>

namespace headway::drivers {

namespace {
/// A joint so near to where it is to be has arrived.
constexpr std::int32_t kNear = 100;

std::int32_t rounded(double position) noexcept { return static_cast<std::int32_t>(std::lround(position)); }
}  // namespace

void CyclicSetPoints::start(std::int32_t position, Time now) noexcept {
  stand(position);
  wanted_ = limits_.clamped(position);
  followed_ = now;
  settled_ = timed_out_ = false;
}

void CyclicSetPoints::stand(std::int32_t position) noexcept {
  ramp_.stand(position);
  next_ = ramp_;
  wire_ = {std::min(limits_.lower, position), std::max(limits_.upper, position)};
}

void CyclicSetPoints::hold(bool hold, std::int32_t /*position*/) noexcept {
  if (held_ && !hold) wanted_ = limits_.clamped(rounded(ramp_.position()));
  held_ = hold;
}

void CyclicSetPoints::tick(const DriveSight& seen, Time now, double part_until_next_sync) noexcept {
  const bool follows = (seen.statusword & hal::cia402::status_bit::kFollows) != 0;
  if (follows || seen.silent) followed_ = now;
  timed_out_ = now - followed_ > timeout_;
  if (!follows) {
    // A way made meanwhile would be a jump once it follows again.
    stand(seen.position);
    return;
  }
  settled_ = true;
  next_ = ramp_;
  if (held_ || seen.silent)
    next_.step_to_rest(part_until_next_sync);
  else
    next_.step_towards(wanted_, part_until_next_sync);
}

void CyclicSetPoints::pause(Time now) noexcept {
  ramp_.stand(ramp_.position());
  followed_ = now;
}

std::int32_t CyclicSetPoints::target() const noexcept { return wire_.clamped(rounded(next_.position())); }

bool CyclicSetPoints::is_moving(const DriveSight& seen) const noexcept {
  const bool under_way = ramp_.velocity() != 0 || (!held_ && ramp_.position() != wanted_);
  return !settled_ || under_way || std::abs(seen.position - rounded(ramp_.position())) > kNear;
}

}  // namespace headway::drivers
