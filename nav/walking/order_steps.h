// The steps that a walk order means. The vision computer plans on them and the control computer walks them;
// so both ask here.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "hal/footstep.h"
#include "hal/walk_order.h"
#include "nav/walking/gait.h"

namespace headway::nav {

struct OrderSteps {
  static constexpr std::size_t kMost = 32;
  std::array<hal::Footstep, kMost> steps{};
  std::size_t count = 0;

  std::span<const hal::Footstep> all() const noexcept { return {steps.data(), count}; }
};

/// The steps of an order from a stance; `last_foot` landed last in it, nothing at rest.
///
/// Step i of n takes the base to share i / n of the way: forward and in yaw, or of the angle around the
/// centre. Sideways only the steps of the foot on that side take it on, each by the same share. The foot
/// lands where that base carries it, seen from the foot that stands and rounded to what a step message holds;
/// the next step is measured from there. n is the least number, up to kMost, for which every step keeps the
/// limits; for kNextStep it is 1. At rest the foot begins that makes n less, the left one of equals.
///
/// Nothing when no such number is found. Real-time safe.
std::optional<OrderSteps> steps_of(const hal::WalkOrder& order, const hal::Stance& from,
                                   std::optional<hal::Foot> last_foot, const GaitLimits& gait) noexcept;

}  // namespace headway::nav
