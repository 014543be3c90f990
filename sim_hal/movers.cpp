#include "sim_hal/movers.h"

#include <algorithm>

namespace headway::sim {

namespace {

constexpr double kStep = 0.02;  // between the moments at which a moving thing is looked at [s]

constexpr double kUnderWay = 0.2;  // a robot that has walked so far no longer looks around at its start [m]

bool sets_off_seen(const MovingThing& thing, const WorldState& state, const Pose2& robot,
                   const Onlooker& onlooker) {
  const Trigger& trigger = thing.starts;
  if (state.walked < kUnderWay) return false;
  if ((robot.position() - trigger.near).norm() > trigger.value) return false;
  if (soonest_touch(thing, Duration{}, robot.position(), onlooker) < trigger.warning) return false;
  const Solid& solid = thing.thing.solid;
  return onlooker.sees({trigger.near.x(), trigger.near.y(), solid.centre_height()});
}

bool triggered(const MovingThing& thing, const WorldState& state, const Pose2& robot,
               const Onlooker* onlooker) {
  const Trigger& trigger = thing.starts;
  switch (trigger.kind) {
    case Trigger::Kind::kAtTime:
      return to_seconds(state.now) >= trigger.value;
    case Trigger::Kind::kRobotWithin:
      return (robot.position() - trigger.near).norm() <= trigger.value;
    case Trigger::Kind::kRobotWalked:
      return state.walked >= trigger.value;
    case Trigger::Kind::kRobotSees:
      return onlooker && sets_off_seen(thing, state, robot, *onlooker);
  }
  return false;
}

}  // namespace

WorldState initial_state(const World& world) {
  WorldState state;
  state.set_off.resize(world.moving.size());
  return state;
}

double soonest_touch(const MovingThing& thing, Duration since, const Eigen::Vector2d& robot,
                     const Onlooker& onlooker) {
  const Solid place = Solid::cylinder({robot.x(), robot.y(), 0}, 0, 1);
  const auto gap = [&](double after) {
    Solid solid = thing.thing.solid;
    solid.pose = thing.pose_at(since + seconds(after));
    return floor_distance(solid, place) - onlooker.radius;
  };
  const double moves = std::max(to_seconds(thing.path.back().after - since), 0.0);
  for (double after = 0; after < moves; after += kStep)
    if (gap(after) <= onlooker.speed * after) return after;
  return std::max(moves, gap(moves) / onlooker.speed);
}

WorldState advanced(const World& world, WorldState state, Time now, const Pose2& robot,
                    const Onlooker* onlooker) {
  if (state.robot) state.walked += (robot.position() - state.robot->position()).norm();
  state.robot = robot;
  state.now = std::max(state.now, now);
  for (std::size_t i = 0; i < world.moving.size(); ++i)
    if (!state.set_off[i] && triggered(world.moving[i], state, robot, onlooker)) state.set_off[i] = state.now;
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
