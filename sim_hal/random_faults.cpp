#include "sim_hal/random_faults.h"

#include <cmath>

#include "sim_hal/dice.h"

namespace headway::sim {

namespace {

/// Whole milliseconds, so that a plan that is written down is the same plan.
Duration in_ms(double s) { return seconds(std::round(s * 1e3) / 1e3); }

Fault random_fault(Dice& dice, const RandomFaultsConfig& config) {
  const auto kinds = fault_kinds();
  const FaultTraits& kind =
      kinds[static_cast<std::size_t>(dice.whole(0, static_cast<int>(kinds.size()) - 1))];
  Fault fault{.kind = kind.kind, .after = FaultClock::kFirstStep};
  fault.begin = in_ms(dice.between(0, to_seconds(config.walk)));
  if (kind.uses.length)
    fault.length = in_ms(config.shortest * std::pow(config.longest / config.shortest, dice.between(0, 1)));
  if (kind.uses.share) fault.share = dice.chance(0.5) ? 1 : dice.between(0.05, 0.95);
  if (kind.uses.delay) fault.delay = in_ms(0.02 * std::pow(100, dice.between(0, 1)));  // 20 ms to 2 s
  if (kind.uses.noise) fault.noise = dice.between(3, 60);
  if (kind.uses.light) fault.light = dice.chance(0.5) ? dice.between(0, 0.1) : dice.between(0.1, 0.6);
  if (kind.uses.jump) fault.jump = in_ms(dice.between(-60, 60));
  return fault;
}

}  // namespace

FaultPlan random_faults(std::uint64_t seed, const RandomFaultsConfig& config) {
  Dice dice(noise_key(seed, 0xfa017, 1));
  FaultPlan plan;
  for (int left = dice.whole(config.fewest, config.most); left > 0; --left)
    plan.push_back(random_fault(dice, config));
  return plan;
}

}  // namespace headway::sim
