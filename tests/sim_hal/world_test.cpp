#include "sim_hal/world.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "sim_hal/movers.h"
#include "sim_hal/random_world.h"
#include "sim_hal/reachable.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"

namespace headway::sim {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using testing::HasSubstr;

const std::filesystem::path kWorlds = source_dir() / "config/worlds";

World shipped(const std::string& name) { return read_world(kWorlds / (name + ".yaml")); }

World parsed(const std::string& text) { return world_from(config::Section::parse(text, "w.yaml")); }

const std::string kSmall = R"(name: small
start: [0, 0, 90]
goal: [2, 1]
textures:
  - {name: card, brightness: 0.7}
  - {name: tiles, kind: checker, grain: 0.2}
floor: {size: [8, 8], texture: tiles}
boxes:
  - {name: crate, centre: [2, 0, 0.5], size: [1, 0.6, 1], yaw_deg: 30, texture: card}
cylinders:
  - {name: bin, base: [-1, 0, 0.1], radius: 0.2, height: 0.6}
moving:
  - name: cart
    box: {size: [0.4, 0.6, 0.8]}
    starts_when: {robot_walked: 1.5}
    speed: 0.5
    path: [{x: 1, y: 2}, {x: 2, y: 2}, {x: 2, y: 3, yaw_deg: 90}]
)";

// The same file with one line replaced.
World changed(const std::string& from, const std::string& to) {
  std::string text = kSmall;
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("no such line: " + from);
  return parsed(text.replace(at, from.size(), to));
}

std::string error_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(WorldFile, SaysWhatTheWorldIs) {
  const World w = parsed(kSmall);
  EXPECT_EQ(w.name, "small");
  EXPECT_NEAR(w.start.yaw, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(w.goal->position, Vector2d(2, 1));
  EXPECT_FALSE(w.goal->yaw);
  ASSERT_EQ(w.things.size(), 2U);
  const Solid& crate = w.things[0].solid;
  EXPECT_EQ(crate.shape, Shape::kBox);
  EXPECT_DOUBLE_EQ(crate.bottom, 0);
  EXPECT_DOUBLE_EQ(crate.top, 1);
  EXPECT_NEAR(crate.pose.yaw, std::numbers::pi / 6, 1e-12);
  EXPECT_EQ(w.textures[static_cast<std::size_t>(w.floor.texture)].kind, Texture::Kind::kChecker);
  EXPECT_EQ(w.things[1].texture, 0);
  EXPECT_DOUBLE_EQ(w.things[1].solid.top, 0.7);
  ASSERT_EQ(w.moving.size(), 1U);
  EXPECT_EQ(w.moving[0].starts.kind, Trigger::Kind::kRobotWalked);
  EXPECT_EQ(w.moving[0].path.size(), 3U);
}

TEST(WorldFile, NamesFileLineAndKeyOfEachFault) {
  const auto fault = [](const std::string& from, const std::string& to) {
    return error_of([&] { changed(from, to); });
  };
  EXPECT_THAT(error_of([] { read_world("/nowhere/w.yaml"); }),
              HasSubstr("/nowhere/w.yaml: no such world file"));
  EXPECT_THAT(fault("start: [0, 0, 90]", "start: [0, 0]"), HasSubstr("w.yaml:2: start"));
  EXPECT_THAT(fault("start: [0, 0, 90]", "start: [2, 0, 90]"), HasSubstr("in an obstacle"));
  EXPECT_THAT(fault("start: [0, 0, 90]", "start: [9, 0, 90]"), HasSubstr("off the floor"));
  EXPECT_THAT(fault("goal: [2, 1]", "goal: home"), HasSubstr("w.yaml:3: goal"));
  EXPECT_THAT(fault("goal: [2, 1]", "gaol: [2, 1]"), HasSubstr("w.yaml:3: gaol"));
  EXPECT_THAT(fault("brightness: 0.7", "brightness: 1.7"), HasSubstr("w.yaml:5: textures[0].brightness"));
  EXPECT_THAT(fault("kind: checker", "kind: tartan"), HasSubstr("'tartan', expected one of"));
  EXPECT_THAT(fault("name: tiles,", "name: card,"), HasSubstr("already the name"));
  EXPECT_THAT(fault("texture: tiles", "texture: tile"),
              HasSubstr("w.yaml:7: floor.texture: 'tile' is not a texture"));
  EXPECT_THAT(fault("size: [1, 0.6, 1]", "size: [1, -0.6, 1]"), HasSubstr("w.yaml:9: boxes[0].size"));
  EXPECT_THAT(fault("radius: 0.2", "radius: 0"), HasSubstr("w.yaml:11: cylinders[0].radius"));
  EXPECT_THAT(fault("radius: 0.2", "radios: 0.2"),
              HasSubstr("w.yaml:11: cylinders[0].radios: is not a key here, did you mean 'radius'?"));
  EXPECT_THAT(fault("yaw_deg: 30,", "yaw: 30,"), HasSubstr("w.yaml:9: boxes[0].yaw"));
  EXPECT_THAT(fault("robot_walked: 1.5", "robot_walked: 1.5, at_time: 3"),
              HasSubstr("expected one of: at_time"));
  EXPECT_THAT(fault("speed: 0.5", "speed: 0"), HasSubstr("w.yaml:16: moving[0].speed"));
  EXPECT_THAT(fault("    speed: 0.5\n", ""), HasSubstr("moving[0].path[1]: the key 't'"));
  EXPECT_THAT(fault("box: {size: [0.4, 0.6, 0.8]}", "sphere: {radius: 1}"),
              HasSubstr("either a 'box' or a 'cylinder'"));
  EXPECT_THAT(fault("path: [{x: 1, y: 2}, {x: 2, y: 2}, {x: 2, y: 3, yaw_deg: 90}]", "path: []"),
              HasSubstr("moving[0].path"));
}

TEST(WorldFile, RefusesMoreThanAWorldCanBeBeforeItIsMade) {
  std::string aliases =
      "name: w\nstart: [0, 0, 0]\nshelves:\n- &s {at: [1, 1, 0], size: [0.4, 1, 2], boards: 50}\n";
  for (int i = 0; i < 6000; ++i) aliases += "- *s\n";
  EXPECT_THAT(error_of([&] { parsed(aliases); }), HasSubstr("lists 6001 things, expected at most 5000"));
  std::string way = "{x: 1, y: 2}";
  for (int i = 0; i < 2000; ++i) way += i % 2 == 0 ? ", {x: 499, y: 2}" : ", {x: 1, y: 2}";
  EXPECT_THAT(error_of([&] {
                changed("path: [{x: 1, y: 2}, {x: 2, y: 2}, {x: 2, y: 3, yaw_deg: 90}]",
                        "path: [" + way + "]");
              }),
              HasSubstr("moving[0].speed: 0.5 m/s, at which the path takes 1.99e+06 s"));
}

TEST(WorldFile, TakesNoHarmFromTruncatedAndMutatedText) {
  std::ifstream in(kWorlds / "lab.yaml");
  std::stringstream whole;
  whole << in.rdbuf();
  const std::string text = whole.str() + kSmall.substr(kSmall.find("moving:"));
  ASSERT_NO_THROW(parsed(text));
  int refused = 0, tried = 0;
  const auto try_it = [&](const std::string& t) {
    ++tried;
    try {
      parsed(t);
    } catch (const InputError& e) {
      ++refused;
      EXPECT_THAT(e.what(), HasSubstr("w.yaml")) << t;
    }
  };
  for (std::size_t n = 0; n < text.size(); n += 23) try_it(text.substr(0, n));
  std::mt19937_64 dice(1);
  for (int i = 0; i < 400; ++i) {
    std::string t = text;
    for (int k = 0; k < 3; ++k) t[dice() % t.size()] = "\0-{}[]:,x9.#&*\n\xff"[dice() % 17];
    try_it(t);
  }
  EXPECT_GT(refused, tried / 2);
}

TEST(WorldFile, FurnitureStandsOnTheFloorWithinItsMeasures) {
  World w;
  const Pose2 at{1, 2, 0.7};
  add_table(w, "table", at, {1.5, 0.8, 0.75}, false, 0);
  EXPECT_EQ(w.things.size(), 5U);
  add_table(w, "table", at, {1.5, 0.8, 0.75}, true, 0);
  add_shelves(w, "shelves", at, {1.5, 0.8, 0.75}, 3, 0);
  const Solid hull = Solid::box({1, 2, 0.375}, {1.5 + 1e-9, 0.8 + 1e-9, 0.75 + 1e-9}, 0.7);
  for (const Thing& t : w.things)
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        for (const double z : {-0.5, 0.5})
          EXPECT_TRUE(hull.contains(
              t.solid.from_own({x * t.solid.length, y * t.solid.width, z * (t.solid.top - t.solid.bottom)})))
              << t.name;
}

TEST(ShippedWorlds, OfferAWayExceptTheBlockedOne) {
  for (const char* name : {"lab", "moving_box", "maze"}) {
    const World w = shipped(name);
    EXPECT_TRUE(reachable(w, w.solids(), 0.55)) << name;
  }
  const World blocked = shipped("blocked");
  EXPECT_FALSE(reachable(blocked, blocked.solids(), 0.05));
}

TEST(ShippedWorlds, LeaveANarrowPassageThroughTheLaboratory) {
  const World lab = shipped("lab");
  const auto solid = [&](const std::string& name) {
    for (const Thing& t : lab.things)
      if (t.name == name) return t.solid;
    throw std::logic_error("no " + name);
  };
  EXPECT_NEAR(floor_distance(solid("cabinet"), solid("bench")), 1.15, 1e-9);
}

TEST(ShippedWorlds, TheSlidingBoxEndsOnTheStraightWayAndLeavesAWayAround) {
  const World w = shipped("moving_box");
  ASSERT_EQ(w.moving.size(), 1U);
  const MovingThing& m = w.moving[0];
  Solid box = m.thing.solid;
  const auto blocks_straight_way = [&] {
    const Vector2d from = w.start.position(), to = w.goal->position, middle = (from + to) / 2;
    return floor_distance(box, Solid::box({middle.x(), middle.y(), 1}, {(to - from).norm(), 0.5, 2})) == 0;
  };
  EXPECT_FALSE(blocks_straight_way());
  box.pose = m.path.back().pose;
  EXPECT_TRUE(blocks_straight_way());
  World after = w;
  after.moving.clear();
  after.things.push_back({"box", box, 0});
  EXPECT_TRUE(reachable(after, after.solids(), 0.6));
  // It is not a trap: the robot is triggered from farther than it can come while the box moves.
  EXPECT_GT(m.starts.value - 0.25 * to_seconds(m.path.back().after), 0.6);
}

TEST(MovingThing, FollowsItsPathAtItsSpeed) {
  const MovingThing cart = parsed(kSmall).moving[0];
  EXPECT_EQ(cart.pose_at(seconds(0)).position(), Vector2d(1, 2));
  EXPECT_TRUE(cart.pose_at(seconds(1)).position().isApprox(Vector2d(1.5, 2)));
  EXPECT_TRUE(cart.pose_at(seconds(3)).position().isApprox(Vector2d(2, 2.5)));
  EXPECT_NEAR(cart.pose_at(seconds(3)).yaw, std::numbers::pi / 4, 1e-9);
  EXPECT_EQ(cart.pose_at(seconds(100)).position(), Vector2d(2, 3));
}

RC_GTEST_PROP(MovingThing, NeverJumps, ()) {
  const MovingThing cart = parsed(kSmall).moving[0];
  const double t = *rc::gen::inRange(0, 60000) * 1e-4;
  const Vector2d before = cart.pose_at(seconds(t)).position(),
                 after = cart.pose_at(seconds(t + 0.001)).position();
  RC_ASSERT((after - before).norm() <= 0.0005 + 1e-9);
}

TEST(Movers, SetOffWhenTheRobotHasWalkedFarEnough) {
  const World w = parsed(kSmall);
  WorldState s = initial_state(w);
  for (int i = 0; i <= 14; ++i) s = advanced(w, s, at_seconds(i), {0.1 * i, 0, 0});
  EXPECT_FALSE(s.set_off[0]);
  s = advanced(w, s, at_seconds(15), {1.0, 0, 0});  // back again: walked 1.4 + 0.4
  ASSERT_TRUE(s.set_off[0]);
  EXPECT_EQ(*s.set_off[0], at_seconds(15));
  s = advanced(w, s, at_seconds(16), {1.0, 0, 0});
  EXPECT_EQ(*s.set_off[0], at_seconds(15)) << "set off once only";
  EXPECT_TRUE(moving_poses(w, s)[0].position().isApprox(Vector2d(1.5, 2)));
}

TEST(Movers, SetOffWhenTheRobotComesNearOrTheTimeComes) {
  World near = changed("robot_walked: 1.5", "robot_within: 1.0");
  WorldState s = advanced(near, initial_state(near), at_seconds(1), {2, 1.9, 0});
  EXPECT_FALSE(s.set_off[0]) << "1.1 m from its last place";
  EXPECT_TRUE(advanced(near, s, at_seconds(2), {2, 2.1, 0}).set_off[0]);
  World of = changed("robot_walked: 1.5", "robot_within: 1.0, of: [-3, 0]");
  EXPECT_TRUE(advanced(of, initial_state(of), at_seconds(1), {-2.5, 0, 0}).set_off[0]);
  World timed = changed("robot_walked: 1.5", "at_time: 4");
  EXPECT_FALSE(advanced(timed, initial_state(timed), at_seconds(3.999), {}).set_off[0]);
  EXPECT_TRUE(advanced(timed, initial_state(timed), at_seconds(4), {}).set_off[0]);
}

// Independent of reachable(): random walks of a disc, judged by the solids' own distances.
double clearance_along(const std::vector<Solid>& solids, const Vector2d& a, const Vector2d& b) {
  double least = 1e9;
  for (int i = 0; i <= 100; ++i) {
    const Vector2d p = a + (b - a) * (i / 100.0);
    for (const Solid& s : solids)
      least = std::min(least, floor_distance(s, Solid::cylinder({p.x(), p.y(), 0}, 0, 1)));
  }
  return least;
}

TEST(Reachable, AgreesWithAGapOfKnownWidth) {
  const auto with_gap = [](double gap) {
    World w;
    w.floor.size = {6, 4};
    w.start = {-2, 0.3, 0};
    w.goal = Goal2{{2, -0.4}, std::nullopt};
    add_wall(w, "a", {0, 2}, {0, gap / 2}, 1, 0.2, 0);
    add_wall(w, "b", {0, -2}, {0, -gap / 2}, 1, 0.2, 0);
    return w;
  };
  for (const double radius : {0.2, 0.35, 0.55}) {
    const World narrow = with_gap(2 * radius - 0.01), wide = with_gap(2 * radius + 0.16);
    EXPECT_FALSE(reachable(narrow, narrow.solids(), radius)) << radius;
    EXPECT_TRUE(reachable(wide, wide.solids(), radius)) << radius;
  }
}

TEST(Reachable, HoldsWhereverTheStraightWayIsFree) {
  int free_ways = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    World w = random_world(seed, {.moving_share = 0});
    if (clearance_along(w.solids(), w.start.position(), w.goal->position) < 0.65) continue;
    ++free_ways;
    EXPECT_TRUE(reachable(w, w.solids(), 0.55));
  }
  EXPECT_GT(free_ways, 2);
}

TEST(RandomWorld, HoldsWhatItPromises) {
  const RandomWorldConfig config;
  int moving = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const World w = random_world(seed);
    ASSERT_TRUE(w.goal);
    EXPECT_GE((w.goal->position - w.start.position()).norm(), config.walk);
    EXPECT_TRUE(reachable(w, w.solids(), config.clearance)) << seed;
    for (const Solid& s : w.solids()) {
      const bool furniture_or_tall = s.top >= 0.25;
      EXPECT_TRUE(furniture_or_tall) << seed;
      for (const Vector2d& p : {w.start.position(), w.goal->position})
        EXPECT_GE(floor_distance(s, Solid::cylinder({p.x(), p.y(), 0}, 0, 1)), config.clearance) << seed;
    }
    for (const MovingThing& m : w.moving) {
      ++moving;
      std::vector<Solid> all = w.solids();
      for (int i = 0; i <= 20; ++i) {
        all.back().pose = m.pose_at(seconds(to_seconds(m.path.back().after) * i / 20));
        for (std::size_t k = 0; k + 1 < all.size(); ++k) EXPECT_FALSE(overlap(all[k], all.back())) << seed;
      }
      EXPECT_TRUE(reachable(w, all, config.clearance)) << seed;
    }
  }
  EXPECT_GT(moving, 5);
  EXPECT_LT(moving, 30);
}

TEST(RandomWorld, IsTheSameForTheSameSeed) {
  const World a = random_world(11), b = random_world(11), c = random_world(12);
  ASSERT_EQ(a.things.size(), b.things.size());
  for (std::size_t i = 0; i < a.things.size(); ++i) {
    EXPECT_EQ(a.things[i].solid.pose.x, b.things[i].solid.pose.x);
    EXPECT_EQ(a.things[i].solid.top, b.things[i].solid.top);
  }
  EXPECT_NE(a.start.x, c.start.x);
}

TEST(RandomWorld, RefusesARoomTooSmallForTheWalk) {
  EXPECT_THROW(random_world(1, {.room = {2, 2}}), InputError);
  EXPECT_THROW(random_world(1, {.room = {3.2, 2.5}, .fewest = 40, .most = 40, .walk = 1.0}), InputError);
}

}  // namespace
}  // namespace headway::sim
