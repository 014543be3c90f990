// Is there a way at all? For worlds that are made up, and for tests of planners.
#pragma once

#include <vector>

#include "sim_hal/world.h"

namespace headway::sim {

/// Can a disc of radius `clearance` [m] go from the world's start to its goal among these solids, within the
/// floor? Judged on a grid of 5 cm, rounded to the safe side: true is true. False without a goal.
bool reachable(const World& world, const std::vector<Solid>& solids, double clearance);

/// The shortest such way, by the centres of the grid's cells from the start's to the goal's; empty when there
/// is none.
std::vector<Eigen::Vector2d> shortest_way(const World& world, const std::vector<Solid>& solids,
                                          double clearance);

}  // namespace headway::sim
