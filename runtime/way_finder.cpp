#include "runtime/way_finder.h"

#include <algorithm>

namespace headway::runtime {

/// Feet know of what is low also where the path was planned as if it blocked.
Way WayFinder::along(const nav::FloorMap& planned_on, const nav::FloorMap& floor,
                     const nav::Committed& committed, const nav::Goal& goal) {
  Way way;
  way.plan = planner_.plan(planned_on, nav::gait_base(committed.stance, committed.last_foot, gait_), goal);
  if (!way.plan) return way;
  way.walk = nav::walk_along(execution_, way.plan.path, committed.stance, committed.last_foot, floor, gait_);
  return way;
}

Way WayFinder::find(const nav::FloorMap& floor, const nav::Committed& committed, const nav::Goal& goal) {
  Way way = along(floor, floor, committed, goal);
  if (!way.walk.treads_on_low) return way;
  nav::FloorMap around = floor;
  std::ranges::replace(around.cells, nav::Floor::kLow, nav::Floor::kBlocked);
  return along(around, floor, committed, goal);
}

}  // namespace headway::runtime
