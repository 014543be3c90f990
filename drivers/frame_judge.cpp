#include "drivers/frame_judge.h"

namespace headway::drivers {

FrameVerdict FrameJudge::judge(const FilledBuffer& frame, Time now) noexcept {
  return {.kind = kind_of(frame, now), .exposure = middle_of(frame), .lost = gap_before(frame.sequence)};
}

std::uint64_t FrameJudge::gap_before(std::uint32_t sequence) noexcept {
  // Modulo 2^32, so that the count may run over.
  const std::uint32_t step = sequence_ ? sequence - *sequence_ : 1;
  sequence_ = sequence;
  return step == 0 || step > kLargestGap ? 0 : step - 1;
}

FrameKind FrameJudge::kind_of(const FilledBuffer& frame, Time now) noexcept {
  if (frame.is_marked || frame.bytes < measure_.least) return FrameKind::kDamaged;
  if (!frame.is_monotonic) return FrameKind::kWrongClock;
  if (frame.stamp == stamp_) return FrameKind::kFrozen;
  const Duration age = now.time_since_epoch() - frame.stamp;
  if (age < -kAhead || age > kOldest || (stamp_ && frame.stamp < *stamp_)) return FrameKind::kWrongClock;
  stamp_ = frame.stamp;
  return FrameKind::kUsable;
}

Time FrameJudge::middle_of(const FilledBuffer& frame) const noexcept {
  const bool at_start = frame.stamp_at == FilledBuffer::StampAt::kStartOfExposure;
  return Time(frame.stamp) + (at_start ? measure_.exposure / 2 : -(measure_.readout + measure_.exposure / 2));
}

}  // namespace headway::drivers
