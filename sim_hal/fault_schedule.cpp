#include "sim_hal/fault_schedule.h"

#include <utility>

#include "sim_hal/noise.h"

namespace headway::sim {

FaultSchedule::FaultSchedule(FaultPlan plan, Time power_on, std::uint64_t seed)
    : plan_((validate(plan), std::move(plan))), power_on_(power_on), seed_(seed) {}

void FaultSchedule::first_step(Time at) {
  if (!first_step_) first_step_ = at;
}

std::optional<Time> FaultSchedule::begin(std::size_t index) const {
  const Fault& fault = plan_[index];
  if (fault.after == FaultClock::kPowerOn) return power_on_ + fault.begin;
  if (!first_step_) return std::nullopt;
  return *first_step_ + fault.begin;
}

std::optional<Time> FaultSchedule::end(std::size_t index) const {
  const auto from = begin(index);
  if (!from) return std::nullopt;
  return *from + plan_[index].length;
}

bool FaultSchedule::begun(std::size_t index, Time now) const {
  const auto from = begin(index);
  return from && now >= *from;
}

bool FaultSchedule::on(std::size_t index, Time now) const { return begun(index, now) && now < *end(index); }

bool FaultSchedule::any(FaultKind kind, Time now) const {
  for (std::size_t i = 0; i < plan_.size(); ++i)
    if (plan_[i].kind == kind && on(i, now)) return true;
  return false;
}

double FaultSchedule::draw(std::size_t index, std::uint64_t count) const {
  return uniform(noise_key(seed_, index, 0xfa017), count);
}

}  // namespace headway::sim
