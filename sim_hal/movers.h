// Triggers and moves what moves in the world.
#pragma once

#include <vector>

#include "sim_hal/scene.h"

namespace headway::sim {

/// The state at the beginning: nothing has set off.
WorldState initial_state(const World& world);

/// The state at `now`, with the robot there. Triggers are judged at the given moments only: a thing sets off
/// at `now`. The way walked adds up straight lines between calls.
WorldState advanced(const World& world, WorldState state, Time now, const Pose2& robot);

/// Where each moving thing is in that state.
std::vector<Pose2> moving_poses(const World& world, const WorldState& state);

}  // namespace headway::sim
