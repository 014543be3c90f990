#include "sim_hal/random_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/error.h"
#include "sim_hal/dice.h"
#include "sim_hal/reachable.h"

namespace headway::sim {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

constexpr double kPi = std::numbers::pi;

void add_textures(World& world) {
  world.textures = {{.name = "floor", .brightness = 0.42, .contrast = 0.55, .grain = 0.006, .octaves = 5},
                    {.name = "wall", .brightness = 0.6, .contrast = 0.4, .grain = 0.006, .octaves = 5},
                    {.name = "wood", .brightness = 0.5, .contrast = 0.55, .grain = 0.005, .octaves = 4},
                    {.name = "card", .brightness = 0.65, .contrast = 0.5, .grain = 0.005, .octaves = 4}};
}

// One try at a room; the next one has other dice.
class Builder {
 public:
  Builder(std::uint64_t seed, std::uint64_t attempt, const RandomWorldConfig& config)
      : config_(config), dice_(noise_key(seed, attempt, 0x3017d)) {
    world_.name = "random " + std::to_string(seed);
    world_.seed = seed;
  }

  std::optional<World> build() {
    add_textures(world_);
    world_.floor = {{0, 0}, config_.room + Vector2d(0.2, 0.2), 0};
    add_room(world_, {0, 0}, config_.room, 2.4, 1);
    place_start_and_goal();
    const int wanted = dice_.whole(config_.fewest, config_.most);
    const bool moving = dice_.between(0, 1) < config_.moving_share;
    int placed = moving && try_repeatedly([this] { return add_moving(); }) ? 1 : 0;
    while (placed < wanted && try_repeatedly([this] { return add_obstacle(); })) ++placed;
    if (placed < config_.fewest) return std::nullopt;
    return std::move(world_);
  }

 private:
  Vector2d place(double from_wall) {
    const Vector2d half = config_.room / 2 - Vector2d(from_wall, from_wall);
    return {dice_.between(-half.x(), half.x()), dice_.between(-half.y(), half.y())};
  }

  void place_start_and_goal() {
    const double from_wall = config_.clearance + 0.1;
    Vector2d start, goal;
    do {
      start = place(from_wall);
      goal = place(from_wall);
    } while ((goal - start).norm() < config_.walk);
    // Facing roughly the goal: a robot put with its nose to a wall sees nothing, which is no test of its
    // planning.
    const Vector2d way = goal - start;
    const double eighths = std::round(std::atan2(way.y(), way.x()) / (kPi / 4)) + dice_.whole(-1, 1);
    world_.start = {start.x(), start.y(), wrap_angle(kPi / 4 * eighths)};
    world_.goal = Goal2{goal, std::nullopt};
  }

  template <class Try>
  static bool try_repeatedly(Try attempt) {
    for (int i = 0; i < 40; ++i)
      if (attempt()) return true;
    return false;
  }

  bool add_obstacle() {
    World with = world_;
    const std::size_t before = with.things.size();
    const Vector2d at = place(0.2);
    const Pose2 pose{at.x(), at.y(), dice_.between(-kPi, kPi)};
    const double pick = dice_.between(0, 1), height = dice_.between(0.25, 1.6);
    if (pick < 0.45) {
      const Vector3d size(dice_.between(0.2, 0.9), dice_.between(0.2, 0.7), height);
      with.things.push_back({"box", Solid::box({at.x(), at.y(), height / 2}, size, pose.yaw), 3});
    } else if (pick < 0.75) {
      with.things.push_back(
          {"cylinder", Solid::cylinder({at.x(), at.y(), 0}, dice_.between(0.1, 0.35), height), 3});
    } else {
      const Vector3d size(dice_.between(0.8, 1.3), dice_.between(0.5, 0.8), dice_.between(0.55, 0.8));
      add_table(with, "table", pose, size, dice_.between(0, 1) < 0.5, 2);
    }
    const std::vector<Solid> added = solids_from(with, before);
    if (!stands_free(added) || !reachable(with, with.solids(), config_.clearance)) return false;
    // What moves must still get to its place, and the way stay open wherever it is.
    for (const MovingThing& m : world_.moving)
      if (!way_stays_open(with, m, added)) return false;
    world_ = std::move(with);
    return true;
  }

  static std::vector<Solid> solids_from(const World& world, std::size_t first) {
    std::vector<Solid> all;
    for (std::size_t i = first; i < world.things.size(); ++i) all.push_back(world.things[i].solid);
    return all;
  }

  // Inside the room, not into other things, and clear of start and goal.
  bool stands_free(const std::vector<Solid>& added) const {
    const Solid start = Solid::cylinder({world_.start.x, world_.start.y, 0}, config_.clearance + 0.05, 2),
                goal = Solid::cylinder({world_.goal->position.x(), world_.goal->position.y(), 0},
                                       config_.clearance + 0.05, 2);
    for (const Solid& s : added) {
      if (floor_distance(s, start) == 0 || floor_distance(s, goal) == 0) return false;
      for (const Thing& other : world_.things)
        if (floor_distance(s, other.solid) < 0.02) return false;
    }
    return true;
  }

  // A box that slides a little, slowly, when the robot is still two metres away: it can be seen and walked
  // around.
  bool add_moving() {
    MovingThing m;
    const double height = dice_.between(0.5, 1.2), direction = dice_.between(-kPi, kPi),
                 way = dice_.between(0.4, 0.7);
    const Vector2d from = place(0.5), to = from + way * Vector2d(std::cos(direction), std::sin(direction));
    m.thing = {"sliding box", Solid::box({from.x(), from.y(), height / 2}, {0.4, 0.5, height}, direction), 3};
    m.path = path_at_speed({{from.x(), from.y(), direction}, {to.x(), to.y(), direction}}, 0.2);
    m.starts = {Trigger::Kind::kRobotWithin, 2.0, to};
    if ((world_.start.position() - to).norm() < 2.4 || !way_stays_open(world_, m, {})) return false;
    world_.moving.push_back(m);
    return true;
  }

  bool way_stays_open(const World& world, const MovingThing& m, const std::vector<Solid>& added) const {
    constexpr int kStops = 6;
    const double length = to_seconds(m.path.back().after);
    for (int i = 0; i <= kStops; ++i) {
      Solid moved = m.thing.solid;
      moved.pose = m.pose_at(seconds(length * i / kStops));
      if (!stands_free({moved})) return false;
      for (const Solid& s : added)
        if (floor_distance(moved, s) < 0.05) return false;
      std::vector<Solid> all = solids_from(world, 0);
      all.push_back(moved);
      if (!reachable(world, all, config_.clearance)) return false;
    }
    return true;
  }

  RandomWorldConfig config_;
  Dice dice_;
  World world_;
};

}  // namespace

World random_world(std::uint64_t seed, const RandomWorldConfig& config) {
  const double least = 2 * config.clearance + 0.4;
  if (!((config.room - Vector2d(least, least)).minCoeff() > 0) ||
      (config.room - Vector2d(least, least)).norm() < config.walk)
    throw InputError(
        "random world: the room is too small for the walk asked for; make it larger or the walk shorter");
  constexpr std::uint64_t kTries = 200;
  for (std::uint64_t attempt = 0; attempt < kTries; ++attempt)
    if (auto world = Builder(seed, attempt, config).build()) return *std::move(world);
  throw InputError("random world: no room for that many obstacles and a way between them; ask for fewer");
}

}  // namespace headway::sim
