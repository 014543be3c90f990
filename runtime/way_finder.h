// From a goal to feet: the cheapest path, and the steps along it.
#pragma once

#include <string>

#include "nav/footsteps.h"
#include "nav/planner.h"
#include "nav/step_stack.h"
#include "nav/walk_orders.h"
#include "nav/walking/gait.h"

namespace headway::runtime {

struct Way {
  nav::PlanResult plan;
  nav::Walk walk;  ///< empty where there is no path
};

class WayFinder {
 public:
  WayFinder(const nav::PlannerConfig& planner, const nav::GaitLimits& gait, const nav::BodyOutline& outline,
            nav::Execution execution, const nav::FloorGrid& grid)
      : planner_(planner, gait, outline, grid), gait_(gait), execution_(execution) {}

  /// From where the committed steps end. Where no feet step over what is low on the cheapest path, the way
  /// that goes around all that is low.
  Way find(const nav::FloorMap& floor, const nav::Committed& committed, const nav::Goal& goal);
  /// Whether there is one at all.
  bool leads(const nav::FloorMap& floor, const nav::Committed& committed, const nav::Goal& goal) {
    return static_cast<bool>(find(floor, committed, goal).plan);
  }

 private:
  Way along(const nav::FloorMap& planned_on, const nav::FloorMap& floor, const nav::Committed& committed,
            const nav::Goal& goal);

  nav::Planner planner_;
  nav::GaitLimits gait_;
  nav::Execution execution_;
};

}  // namespace headway::runtime
