#include "runtime/cycle.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::runtime {

void CycleLimits::validate() const {
  if (most_missed < 0 || most_missed > Cycle::kMostRemembered)
    throw InputError(
        fmt::format("most_missed: {}, expected 0 to {} cycles", most_missed, Cycle::kMostRemembered));
  if (within <= Duration(0))
    throw InputError(fmt::format("missed_within: {} s, expected more than 0", to_seconds(within)));
}

const char* name(CycleHealth health) {
  switch (health) {
    case CycleHealth::kOnTime:
      return "on time";
    case CycleHealth::kLate:
      return "late";
    case CycleHealth::kFailing:
      return "failing";
  }
  return "?";
}

Cycle::Cycle(Duration period, const CycleLimits& limits) : period_(period), limits_(limits) {
  limits_.validate();
}

CycleHealth Cycle::begin(Time now) noexcept {
  if (std::exchange(first_, false)) due_ = now;
  const Duration late = std::max(Duration(0), Duration(now - due_));
  wake_up_delay_.add(late);
  miss(late / period_);
  due_ += period_;
  begun_ = now;
  const CycleHealth health = judge(now);
  health_.store(health, std::memory_order_relaxed);
  return health;
}

void Cycle::miss(std::int64_t count) noexcept {
  const std::uint64_t before = missed_.load(std::memory_order_relaxed);
  const auto size = static_cast<std::int64_t>(missed_at_.size());
  for (std::int64_t i = std::max<std::int64_t>(0, count - size); i < count; ++i)
    missed_at_[(before + static_cast<std::uint64_t>(i)) % missed_at_.size()] = due_ + i * period_;
  missed_.store(before + static_cast<std::uint64_t>(count), std::memory_order_relaxed);
  due_ += count * period_;
}

CycleHealth Cycle::judge(Time now) const noexcept {
  const std::uint64_t missed = missed_.load(std::memory_order_relaxed);
  // Was the one that came so many before the end missed lately?
  const auto lately = [&](int before_last) {
    const auto back = static_cast<std::uint64_t>(before_last) + 1;
    return missed >= back && missed_at_[(missed - back) % missed_at_.size()] > now - limits_.within;
  };
  if (lately(limits_.most_missed)) return CycleHealth::kFailing;
  return lately(limits_.most_missed / kFew) ? CycleHealth::kLate : CycleHealth::kOnTime;
}

}  // namespace headway::runtime
