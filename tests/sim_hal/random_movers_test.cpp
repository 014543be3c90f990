#include "sim_hal/random_movers.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "sim_hal/movers.h"
#include "sim_hal/reachable.h"
#include "sim_hal/scene.h"

namespace headway::sim {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

Time at_seconds(double s) { return Time(seconds(s)); }

/// All solids, moving thing i that far [0, 1] along its way.
std::vector<Solid> solids_with(const World& world, const std::vector<double>& moved) {
  std::vector<Solid> all;
  for (const Thing& t : world.things) all.push_back(t.solid);
  for (std::size_t i = 0; i < world.moving.size(); ++i) {
    all.push_back(world.moving[i].thing.solid);
    all.back().pose =
        world.moving[i].pose_at(seconds(moved[i] * to_seconds(world.moving[i].path.back().after)));
  }
  return all;
}

MovingThing cart(const Vector2d& from, const Vector2d& to, double speed) {
  MovingThing m;
  m.thing = {"cart", Solid::cylinder({from.x(), from.y(), 0}, 0.2, 1), 0};
  m.path = path_at_speed({{from.x(), from.y(), 0}, {to.x(), to.y(), 0}}, speed);
  m.starts = {Trigger::Kind::kRobotSees, 3, to, 4};
  return m;
}

constexpr std::uint64_t kWorlds = 15;

TEST(RandomMovers, LeaveAWayWhateverHasMoved) {
  const RandomMoversConfig config;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const World world = random_moving_world(seed, config);
    const std::size_t count = world.moving.size();
    ASSERT_GT(count, 0U);
    for (unsigned ends = 0; ends < (1U << count); ++ends) {
      std::vector<double> moved;
      for (std::size_t i = 0; i < count; ++i) moved.push_back((ends >> i) & 1U);
      EXPECT_TRUE(reachable(world, solids_with(world, moved), config.room.clearance)) << seed;
      // Between the moments that the generator looked at, a thing goes on by up to a quarter of a metre.
      moved[ends % count] = 0.4;
      EXPECT_TRUE(reachable(world, solids_with(world, moved), config.room.clearance - 0.1)) << seed;
    }
  }
}

TEST(RandomMovers, TouchNothingOnTheirWay) {
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const World world = random_moving_world(seed);
    for (std::size_t i = 0; i < world.moving.size(); ++i)
      for (int k = 0; k <= 50; ++k) {
        std::vector<double> moved(world.moving.size(), k % 2);
        moved[i] = k / 50.0;
        const std::vector<Solid> all = solids_with(world, moved);
        const std::size_t own = world.things.size() + i;
        for (std::size_t other = 0; other < all.size(); ++other)
          EXPECT_TRUE(other == own || !overlap(all[own], all[other])) << seed;
      }
  }
}

TEST(RandomMovers, ComeOntoTheShortestWayAndGiveTheStoppingTime) {
  const RandomMoversConfig config;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const World world = random_moving_world(seed, config);
    bool coming = false;
    for (std::size_t i = 0; i < world.moving.size(); ++i) {
      const MovingThing& m = world.moving[i];
      EXPECT_EQ(m.starts.kind, Trigger::Kind::kRobotSees);
      EXPECT_GE(m.starts.warning, config.warning + to_seconds(m.path.back().after)) << "from when it stands";
      if (m.thing.name != "coming") continue;
      coming = true;
      double nearest = 1e9;
      std::vector<Solid> without = solids_with(world, std::vector<double>(world.moving.size(), 1.0));
      without.resize(world.things.size() + i);
      for (const Vector2d& p : shortest_way(world, without, config.room.clearance))
        nearest = std::min(nearest, (p - m.path.back().pose.position()).norm());
      EXPECT_LT(nearest, 0.05) << seed;
    }
    EXPECT_TRUE(coming) << seed;
  }
}

TEST(RandomMovers, AreTheSameForTheSameSeed) {
  const World a = random_moving_world(11), b = random_moving_world(11), c = random_moving_world(12);
  ASSERT_EQ(a.moving.size(), b.moving.size());
  for (std::size_t i = 0; i < a.moving.size(); ++i) {
    EXPECT_EQ(a.moving[i].thing.solid.pose.x, b.moving[i].thing.solid.pose.x);
    EXPECT_EQ(a.moving[i].path.back().pose.y, b.moving[i].path.back().pose.y);
    EXPECT_EQ(a.moving[i].path.back().after, b.moving[i].path.back().after);
  }
  EXPECT_NE(a.start.x, c.start.x);
}

TEST(RandomMovers, SomeComeAndSomeGo) {
  int coming = 0, going = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const MovingThing& m : random_moving_world(seed).moving)
      ++(m.thing.name == "going" ? going : coming);
  EXPECT_GE(coming, 20);
  EXPECT_GE(going, 4);
  EXPECT_LE(going, 16);
}

TEST(SoonestTouch, IsTheStraightWalkToWhatStands) {
  const MovingThing m = cart({3, 0}, {3, 1}, 0.5);
  const Onlooker robot{nullptr, 0.4, 0.25};
  // From (0, 1), 3 m to the axis of where it comes to stand; on its way there it is no nearer.
  EXPECT_NEAR(soonest_touch(m, seconds(2), {0, 1}, robot), (3 - 0.2 - 0.4) / 0.25, 1e-9);
  EXPECT_NEAR(soonest_touch(m, Duration{}, {0, 1}, robot), (3 - 0.2 - 0.4) / 0.25, 1e-9);
}

TEST(SoonestTouch, IsWhenWhatComesMeetsARobotThatStands) {
  const MovingThing m = cart({3, 0}, {0, 0}, 0.5);
  EXPECT_NEAR(soonest_touch(m, Duration{}, {0, 0}, {nullptr, 0.4, 0}), (3 - 0.6) / 0.5, 0.021);
  EXPECT_NEAR(soonest_touch(m, seconds(2), {0, 0}, {nullptr, 0.4, 0}), (3 - 0.6) / 0.5 - 2, 0.021);
}

TEST(Movers, SetOffBeforeTheRobotsEyesOnly) {
  World world;
  world.moving.push_back(cart({2.5, -1}, {2.5, 0}, 1));  // 3 m near, 4 s before it could be touched
  bool sees = false;
  const Onlooker robot{[&](const Vector3d&) { return sees; }, 0.4, 0.25};
  double walked = 1;
  const auto sets_off = [&](double x, const Onlooker* onlooker) {
    WorldState before = initial_state(world);
    before.walked = walked;
    return advanced(world, before, at_seconds(1), {x, 0, 0}, onlooker).set_off[0].has_value();
  };
  EXPECT_FALSE(sets_off(0.5, &robot)) << "it looks elsewhere";
  sees = true;
  EXPECT_FALSE(sets_off(-1, &robot)) << "too far away";
  EXPECT_TRUE(sets_off(0.5, &robot));
  EXPECT_FALSE(sets_off(1.5, &robot)) << "1 m is walked in 4 s";
  EXPECT_FALSE(sets_off(0.5, nullptr)) << "nobody looks";
  walked = 0;
  EXPECT_FALSE(sets_off(0.5, &robot)) << "it has not begun to walk";
}

}  // namespace
}  // namespace headway::sim
