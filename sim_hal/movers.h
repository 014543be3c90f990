// Triggers and moves what moves in the world.
#pragma once

#include <functional>
#include <vector>

#include "sim_hal/scene.h"

namespace headway::sim {

/// What things that set off before the robot's eyes know of it.
struct Onlooker {
  std::function<bool(const Eigen::Vector3d&)> sees;  ///< a point of the map frame: in view, nothing before it
  double radius = 0.37;                              ///< of a disc that holds its body [m]
  double speed = 0.25;                               ///< its fastest walk [m/s]
};

/// How soon the robot could touch a thing that set off `since` ago, were it to walk the straightest and
/// fastest way to where the thing comes [s]. It comes no sooner than that, whatever way it takes.
double soonest_touch(const MovingThing& thing, Duration since, const Eigen::Vector2d& robot,
                     const Onlooker& onlooker);

/// The state at the beginning: nothing has set off.
WorldState initial_state(const World& world);

/// The state at `now`, with the robot there. Triggers are judged at the given moments only: a thing sets off
/// at `now`. The way walked adds up straight lines between calls. Without an onlooker nobody sees anything.
WorldState advanced(const World& world, WorldState state, Time now, const Pose2& robot,
                    const Onlooker* onlooker = nullptr);

/// Where each moving thing is in that state.
std::vector<Pose2> moving_poses(const World& world, const WorldState& state);

}  // namespace headway::sim
