// What the planner's motions cost anywhere, in whole ticks of time.
#pragma once

#include <array>
#include <cstdint>

#include "nav/masks.h"
#include "nav/planner_config.h"
#include "nav/walking/gait.h"

namespace headway::nav {

/// Sixteen bits hold a cost; what would not fit is kTooDear, and nobody goes that way.
using Ticks = std::uint16_t;
constexpr Ticks kTooDear = 65535;

/// A span of time in ticks of `tick` seconds, rounded to the nearest one; kTooDear when it does not fit.
Ticks in_ticks(double seconds, double tick);
/// Sums that do not fit are kTooDear.
constexpr Ticks sum(std::uint32_t a, std::uint32_t b) {
  return static_cast<Ticks>(a + b < kTooDear ? a + b : kTooDear);
}

struct MotionCosts {
  double tick = 0;                                ///< [s]
  std::array<std::array<Ticks, 3>, 2> forward{};  ///< [diagonal][eighths turned], the turn included
  std::array<std::array<Ticks, 3>, 2> sideway{};  ///< [diagonal][eighths off the heading]
  std::array<Ticks, 2> least{};                   ///< of any motion [diagonal]
  Ticks mode_change = 0;

  /// On a grid of this resolution [m].
  MotionCosts(const PlannerConfig& config, const GaitLimits& gait, double resolution);

  /// Walking and turning time, without what the floor adds.
  Ticks of(const Motion& m) const;
  /// The part of it that is not turning.
  Ticks walking(const Motion& m) const;
};

}  // namespace headway::nav
