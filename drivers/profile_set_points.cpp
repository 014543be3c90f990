#include "drivers/profile_set_points.h"

namespace headway::drivers {

namespace cia402 = hal::cia402;

namespace {
constexpr int kOffers = 3;
}

void ProfileSetPoints::start(std::int32_t position, Time now) noexcept {
  stay(position);
  accepted_ = offered_ = wanted_;
  unanswered_ = 0;
  timed_out_ = false;
  handshake_ = Handshake::kWithdrawing;  // an acknowledgement left over must go first
  since_ = now;
}

void ProfileSetPoints::stay(std::int32_t position) noexcept {
  wanted_ = limits_.clamped(position);
  settling_ = true;
}

void ProfileSetPoints::hold(bool hold, std::int32_t position) noexcept {
  if (held_ && !hold) stay(position);
  held_ = hold;
}

/// A drive that makes its own way needs no SYNC.
void ProfileSetPoints::tick(const DriveSight& seen, Time now, double /*part_until_next_sync*/) noexcept {
  const bool acknowledged = (seen.statusword & cia402::status_bit::kSetPointAcknowledged) != 0;
  if (handshake_ == Handshake::kOffered) {
    await_acknowledgement(acknowledged, now);
  } else if (handshake_ == Handshake::kWithdrawing && !acknowledged) {
    handshake_ = Handshake::kIdle;
  } else if (handshake_ == Handshake::kWithdrawing && now - since_ > timeout_) {
    timed_out_ = true;
  }
  const bool news = settling_ || wanted_ != accepted_;
  if (handshake_ == Handshake::kIdle && news && !acknowledged && !held_) {
    // Staying means where it is now, not where it was when it was told to.
    if (settling_) wanted_ = limits_.clamped(seen.position);
    offered_ = wanted_;
    handshake_ = Handshake::kOffered;
    since_ = now;
  }
}

void ProfileSetPoints::await_acknowledgement(bool acknowledged, Time now) noexcept {
  if (!acknowledged && now - since_ <= timeout_) return;
  handshake_ = Handshake::kWithdrawing;
  since_ = now;
  if (acknowledged) {
    accepted_ = offered_;
    settling_ = false;
    unanswered_ = 0;
  } else if (++unanswered_ >= kOffers) {
    timed_out_ = true;
  }
}

std::uint16_t ProfileSetPoints::bits() const noexcept {
  std::uint16_t bits = 0;
  if (handshake_ == Handshake::kOffered)
    bits |= cia402::control_bit::kNewSetPoint | cia402::control_bit::kChangeAtOnce;
  if (held_) bits |= cia402::control_bit::kHalt;
  return bits;
}

bool ProfileSetPoints::is_moving(const DriveSight& seen) const noexcept {
  const bool reached = (seen.statusword & cia402::status_bit::kTargetReached) != 0;
  return settling_ || wanted_ != accepted_ || !reached;
}

}  // namespace headway::drivers
