// Brings the cost-to-goal in line with a floor that has changed, so that the next search goes on from there.
#pragma once

#include <vector>

#include "nav/cost_sweep.h"
#include "nav/floor_chunks.h"

namespace headway::nav {

/// Costs are made one from another: each by way of states that cost less. So where something has become
/// dearer, all that cost no less than the cheapest state it touches is forgotten, and the rest still holds.
/// What lies beside the forgotten, or leads out of where something has become cheaper, is to be passed on
/// again.
void repair(CostSweep& sweep, const std::vector<ChunkChange>& changes);

}  // namespace headway::nav
