#include "sim_hal/movers.h"

#include <algorithm>

namespace headway::sim {

namespace {

bool triggered(const Trigger& trigger, const WorldState& state, const Pose2& robot) {
  switch (trigger.kind) {
    case Trigger::Kind::kAtTime:
      return to_seconds(state.now) >= trigger.value;
    case Trigger::Kind::kRobotWithin:
      return (robot.position() - trigger.near).norm() <= trigger.value;
    case Trigger::Kind::kRobotWalked:
      return state.walked >= trigger.value;
  }
  return false;
}

}  // namespace

WorldState initial_state(const World& world) {
  WorldState state;
  state.set_off.resize(world.moving.size());
  return state;
}

WorldState advanced(const World& world, WorldState state, Time now, const Pose2& robot) {
  if (state.robot) state.walked += (robot.position() - state.robot->position()).norm();
  state.robot = robot;
  state.now = std::max(state.now, now);
  for (std::size_t i = 0; i < world.moving.size(); ++i)
    if (!state.set_off[i] && triggered(world.moving[i].starts, state, robot)) state.set_off[i] = state.now;
  return state;
}

std::vector<Pose2> moving_poses(const World& world, const WorldState& state) {
  std::vector<Pose2> poses;
  poses.reserve(world.moving.size());
  for (std::size_t i = 0; i < world.moving.size(); ++i) {
    const auto& since = state.set_off[i];
    poses.push_back(world.moving[i].pose_at(since ? state.now - *since : Duration{}));
  }
  return poses;
}

}  // namespace headway::sim
