// Which faults of a plan are on at a moment: what all parts of the simulated robot ask.
#pragma once

#include <cstdint>
#include <optional>

#include "sim_hal/faults.h"

namespace headway::sim {

class FaultSchedule {
 public:
  /// Throws InputError as validate().
  explicit FaultSchedule(FaultPlan plan = {}, Time power_on = {}, std::uint64_t seed = 1);

  /// From then on the faults that wait for the first step have a time. The first call counts.
  void first_step(Time at);

  const FaultPlan& plan() const { return plan_; }
  /// Nothing while it is not known.
  std::optional<Time> begin(std::size_t index) const;
  std::optional<Time> end(std::size_t index) const;
  /// It has begun and not ended: from `begin` up to, and without, `end`.
  bool on(std::size_t index, Time now) const;
  bool begun(std::size_t index, Time now) const;
  /// Whether one of that kind is on.
  bool any(FaultKind kind, Time now) const;
  /// The same number in [0, 1) on every run for each fault and count.
  double draw(std::size_t index, std::uint64_t count) const;

 private:
  FaultPlan plan_;
  Time power_on_;
  std::uint64_t seed_;
  std::optional<Time> first_step_;
};

}  // namespace headway::sim
