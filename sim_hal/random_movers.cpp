#include "sim_hal/random_movers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "hal/error.h"
#include "sim_hal/dice.h"
#include "sim_hal/reachable.h"

namespace headway::sim {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

constexpr double kBesideThings = 0.05;  // kept free between a moving thing and all others [m]
constexpr double kFirst = 2.2;          // of the way from the start stays as it is [m]
constexpr double kFrame = 0.1;          // until a picture shows what has set off [s]

/// Where a thing stands on the way, and across it.
struct Crossing {
  Vector2d place, across;  ///< [m], unit
};

double length_of(const std::vector<Vector2d>& way) {
  double sum = 0;
  for (std::size_t i = 1; i < way.size(); ++i) sum += (way[i] - way[i - 1]).norm();
  return sum;
}

std::optional<Crossing> crossing_at(const std::vector<Vector2d>& way, double along) {
  for (std::size_t i = 1; i < way.size(); ++i) {
    along -= (way[i] - way[i - 1]).norm();
    if (along > 0) continue;
    // The way's direction over some cells: between two neighbours it is a multiple of 45 degrees.
    const std::size_t before = i > 6 ? i - 6 : 0, after = std::min(i + 6, way.size() - 1);
    const Vector2d ahead = (way[after] - way[before]).normalized();
    return Crossing{way[i], {-ahead.y(), ahead.x()}};
  }
  return std::nullopt;
}

class Builder {
 public:
  Builder(std::uint64_t key, const RandomMoversConfig& config)
      : config_(config), dice_(key), world_(random_world(mixed(key), config.room)) {}

  std::optional<World> build() {
    const int coming = dice_.whole(1, config_.most_coming);
    const bool going = dice_.chance(config_.going_share);
    if (going && !try_repeatedly([this] { return add_going(); })) return std::nullopt;
    for (int i = 0; i < coming; ++i)
      if (!try_repeatedly([this] { return add_coming(); })) return std::nullopt;
    return std::move(world_);
  }

 private:
  template <class Try>
  static bool try_repeatedly(Try attempt) {
    for (int i = 0; i < 20; ++i)
      if (attempt()) return true;
    return false;
  }

  Thing thing(const std::string& name, const Vector2d& at) {
    const double height = dice_.between(0.5, 1.3), yaw = dice_.between(-std::numbers::pi, std::numbers::pi);
    if (dice_.chance(0.3))
      return {name, Solid::cylinder({at.x(), at.y(), 0}, dice_.between(0.15, 0.25), height), 3};
    const Vector3d size(dice_.between(0.3, 0.5), dice_.between(0.3, 0.6), height);
    return {name, Solid::box({at.x(), at.y(), height / 2}, size, yaw), 3};
  }

  /// Sets off before the robot's eyes, and stands before the robot could be there.
  MovingThing moving(Thing thing, const Vector2d& to) {
    MovingThing m;
    const Pose2 from = thing.solid.pose;
    m.thing = std::move(thing);
    m.path = path_at_speed({from, {to.x(), to.y(), from.yaw}}, dice_.between(config_.slow, config_.fast));
    m.starts = {Trigger::Kind::kRobotSees, config_.from, to,
                config_.warning + kFrame + to_seconds(m.path.back().after)};
    return m;
  }

  std::optional<Crossing> somewhere_on_the_way() {
    const auto way = shortest_way(world_, solids_at(std::nullopt, 1), config_.room.clearance);
    const double last = length_of(way) - config_.room.clearance - 0.4;
    if (last < kFirst) return std::nullopt;
    return crossing_at(way, dice_.between(kFirst, last));
  }

  double sideways(double least, double most) {
    return (dice_.chance(0.5) ? 1 : -1) * dice_.between(least, most);
  }

  bool add_coming() {
    const auto crossing = somewhere_on_the_way();
    if (!crossing) return false;
    const Vector2d from = crossing->place + sideways(0.9, 1.5) * crossing->across;
    return take(moving(thing("coming", from), crossing->place));
  }

  bool add_going() {
    const auto crossing = somewhere_on_the_way();
    if (!crossing) return false;
    const Vector2d to = crossing->place + sideways(0.9, 1.5) * crossing->across;
    return take(moving(thing("going", crossing->place), to));
  }

  bool take(MovingThing m) {
    if ((world_.start.position() - m.starts.near).norm() < kFirst) return false;
    world_.moving.push_back(std::move(m));
    if (moves_freely(world_.moving.back()) && way_stays_open()) return true;
    world_.moving.pop_back();
    return false;
  }

  static constexpr int kStops = 6;

  static Solid solid_at(const MovingThing& m, int stop) {
    Solid s = m.thing.solid;
    s.pose = m.pose_at(seconds(to_seconds(m.path.back().after) * stop / kStops));
    return s;
  }

  /// All solids, the moving ones at their beginning or (bit i of `moved`: thing i) at their end.
  std::vector<Solid> solids_at(std::optional<unsigned> moved, unsigned otherwise) const {
    std::vector<Solid> all;
    for (const Thing& t : world_.things) all.push_back(t.solid);
    for (std::size_t i = 0; i < world_.moving.size(); ++i)
      all.push_back(solid_at(world_.moving[i], (moved ? *moved >> i : otherwise) & 1U ? kStops : 0));
    return all;
  }

  /// Past all that stands, past the other ways, and clear of start and goal.
  bool moves_freely(const MovingThing& m) const {
    const double keep = config_.room.clearance + 0.05;
    const Solid start = Solid::cylinder({world_.start.x, world_.start.y, 0}, keep, 2),
                goal = Solid::cylinder({world_.goal->position.x(), world_.goal->position.y(), 0}, keep, 2);
    for (int stop = 0; stop <= kStops; ++stop) {
      const Solid s = solid_at(m, stop);
      const Vector2d in = (s.pose.position() - world_.floor.centre).cwiseAbs() - config_.room.room / 2;
      if (in.maxCoeff() > -0.4) return false;
      if (floor_distance(s, start) == 0 || floor_distance(s, goal) == 0) return false;
      for (const Thing& t : world_.things)
        if (floor_distance(s, t.solid) < kBesideThings) return false;
      for (const MovingThing& other : world_.moving)
        for (int at = 0; &other != &m && at <= kStops; ++at)
          if (floor_distance(s, solid_at(other, at)) < kBesideThings) return false;
    }
    return true;
  }

  bool way_stays_open() const {
    const std::size_t count = world_.moving.size(), things = world_.things.size();
    for (unsigned moved = 0; moved < (1U << count); ++moved)
      for (std::size_t i = 0; i < count; ++i)
        for (int stop = 0; stop < kStops; ++stop) {
          std::vector<Solid> all = solids_at(moved, 0);
          all[things + i] = solid_at(world_.moving[i], stop);
          if (!reachable(world_, all, config_.room.clearance)) return false;
        }
    return reachable(world_, solids_at(std::nullopt, 1), config_.room.clearance);
  }

  RandomMoversConfig config_;
  Dice dice_;
  World world_;
};

}  // namespace

World random_moving_world(std::uint64_t seed, const RandomMoversConfig& config) {
  constexpr std::uint64_t kTries = 400;
  for (std::uint64_t attempt = 0; attempt < kTries; ++attempt)
    if (auto world = Builder(noise_key(seed, attempt, 0x30f35), config).build()) {
      world->name = "moving " + std::to_string(seed);
      return *std::move(world);
    }
  throw InputError("random world: no room for things that move and a way around them; make it larger");
}

}  // namespace headway::sim
