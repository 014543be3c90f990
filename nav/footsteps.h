// From a path of cells to prints of feet, on the values that travel to the control computer.
#pragma once

#include <optional>
#include <vector>

#include "hal/footstep.h"
#include "hal/walk_order.h"
#include "nav/planner.h"
#include "nav/walking/gait.h"

namespace headway::nav {

/// Footsteps in order. All are quantised, so the chain of stances is the one that the robot walks.
struct Walk {
  hal::Stance from;  ///< before the first step
  std::vector<hal::Footstep> steps;
  std::vector<hal::Stance> stances;  ///< after each step
  std::vector<Pose2> bases;          ///< carried by the foot that each step lands: where the body goes next
  std::vector<hal::PartOfOrder> orders;  ///< that each step belongs to; empty where steps travel themselves
  bool treads_on_low = false;            ///< no feet were found that step over all low ground on the path

  void add(const hal::Footstep& step, const hal::Stance& after, const Pose2& base) {
    steps.push_back(step);
    stances.push_back(after);
    bases.push_back(base);
  }
};

/// Steps along a path, from the stance after the committed steps. `last_foot`: the foot that lands last in
/// it, so the other one swings next; nothing when at rest, then the better foot begins. The path's start
/// should be gait_base(from, last_foot). The steps follow the lines between cell centres, correct what is off
/// them on the way, step over low ground (as far as it is near: what is far off will look other), and end
/// with parallel feet at path.end (and path.end_yaw). No steps when already there.
Walk place_feet(const Path& path, const hal::Stance& from, std::optional<hal::Foot> last_foot,
                const FloorMap& floor, const GaitLimits& gait);

}  // namespace headway::nav
