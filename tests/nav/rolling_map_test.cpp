// The window that follows the robot.
#include <map>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "attic.h"
#include "nav/integrate.h"
#include "room_map.h"
#include "synthetic_room.h"
#include "tests/heap_count.h"

namespace headway::nav {
namespace {

using Index = VoxelMap::Index;

VoxelMap window() {
  VoxelMapConfig config;
  config.resolution = 0.1;
  config.lowest = {-1.6, -1.6, -0.8};
  config.highest = {1.6, 2.4, 1.6};
  return VoxelMap(config);
}

double metres(double lowest, double highest) {
  return lowest + (highest - lowest) * *rc::gen::inRange(0, 1 << 20) / static_cast<double>(1 << 20);
}

RC_GTEST_PROP(RollingMap, RemembersEveryVoxelWhereverTheWindowHasBeen, ()) {
  VoxelMap map = window();
  Attic attic;
  std::map<std::tuple<int, int, int>, LogOdds> model;  // by place in the world
  const auto place = [&](const Index& i) {
    const Index key = i + map.first_key();
    return std::tuple(key.x(), key.y(), key.z());
  };
  for (int move = 0; move < 8; ++move) {
    for (int change = 0; change < 30; ++change) {
      const Index i(*rc::gen::inRange(0, map.size().x()), *rc::gen::inRange(0, map.size().y()),
                    *rc::gen::inRange(0, map.size().z()));
      const auto value = static_cast<LogOdds>(*rc::gen::inRange(-40, 71));
      map.set(i, value, at_seconds(move));
      model[place(i)] = value;
    }
    map.roll_to({metres(-4, 4), metres(-4, 4), metres(-1, 1)}, &attic);
    for (int z = 0; z < map.size().z(); ++z) {
      for (int y = 0; y < map.size().y(); ++y) {
        for (int x = 0; x < map.size().x(); ++x) {
          const auto known = model.find(place({x, y, z}));
          RC_ASSERT(map.value({x, y, z}) == (known == model.end() ? log_odds::kUnseen : known->second));
        }
      }
    }
    for (std::size_t b = 0; b < map.brick_count(); ++b) {
      RC_ASSERT(map.brick_index(map.brick_at(b)) == b);
      RC_ASSERT(map.summary(b).unseen == std::ranges::count(map.values(b), log_odds::kUnseen));
    }
  }
}

RC_GTEST_PROP(RollingMap, PutsThePointAskedForIntoItsMiddleAndKeepsToOctomapsRaster, ()) {
  VoxelMap map = window();
  const Eigen::Vector3d centre(metres(-50, 50), metres(-50, 50), metres(-5, 5));
  map.roll_to(centre, nullptr);
  const double brick = map.resolution() * kBrickEdge;
  RC_ASSERT(((map.lowest() + map.highest()) / 2 - centre).cwiseAbs().maxCoeff() <= brick / 2 + 1e-9);
  for (int k = 0; k < 3; ++k) RC_ASSERT(map.first_key()[k] % kBrickEdge == 0);
}

TEST(RollingMap, ForgetsWhatLeavesWithoutAStore) {
  VoxelMap map = window();
  const Eigen::Vector3d point(-1.25, 0.05, 0.05);
  map.set(map.index(point), 20, at_seconds(1));
  map.see_floor(map.index(point).x(), map.index(point).y(), at_seconds(1));
  map.roll_to({3, 0.4, 0.4}, nullptr);
  map.roll_to({0, 0.4, 0.4}, nullptr);
  EXPECT_EQ(map.at_point(point), Voxel::kUnseen);
  EXPECT_EQ(map.floor_seen_at(map.index(point).x(), map.index(point).y()), kNever);
}

TEST(RollingMap, KnowsOfAReturningFloorThatItWasSeenWhenItsBrickLastChanged) {
  VoxelMap map = window();
  Attic attic;
  const Eigen::Vector3d point(-1.25, 0.05, 0.05);
  map.set(map.index(point), 20, at_seconds(7));
  map.roll_to({3, 0.4, 0.4}, &attic);
  map.roll_to({0, 0.4, 0.4}, &attic);
  const Index i = map.index(point);
  EXPECT_EQ(map.floor_seen_at(i.x(), i.y()), at_seconds(7));
  EXPECT_EQ(map.floor_seen_at(i.x() + 1, i.y()), kNever);
}

TEST(RollingMap, TakesViewsAsAMapThatNeverMovedWould) {
  const SyntheticRoom room = SyntheticRoom::furnished();
  const vision::PinholeCamera camera = camera_of(170, 240, 33 * kDegree);
  VoxelMap still = room_map();
  VoxelMap rolled = room_map();
  rolled.roll_to({1.3, -0.9, 1.2}, nullptr);
  rolled.roll_to({0.0, 0.0, 1.2}, nullptr);
  ASSERT_EQ(rolled.first_key(), still.first_key());
  const Eigen::Isometry3d pose = camera_pose({-1.2, 0.1, 1.37}, 0.2, 0.3);
  integrate(still, look(room, camera, pose), pose, at_seconds(1));
  integrate(rolled, look(room, camera, pose), pose, at_seconds(1));
  for (int z = 0; z < still.size().z(); ++z)
    for (int y = 0; y < still.size().y(); ++y)
      for (int x = 0; x < still.size().x(); ++x) ASSERT_EQ(still.value({x, y, z}), rolled.value({x, y, z}));
  for (int y = 0; y < still.size().y(); ++y)
    for (int x = 0; x < still.size().x(); ++x)
      ASSERT_EQ(still.floor_seen_at(x, y), rolled.floor_seen_at(x, y));
}

TEST(RollingMap, TakesNoMemoryToRoll) {
  VoxelMap map = window();
  const std::uint64_t before = heap_allocations();
  for (int step = 0; step < 100; ++step) map.roll_to({0.3 * step, -0.2 * step, 0.4}, nullptr);
  EXPECT_EQ(heap_allocations(), before);
}

TEST(RollingMap, StaysWithinOctomapsKeys) {
  VoxelMap map = window();
  map.roll_to({1e7, -1e7, 0}, nullptr);
  EXPECT_LE((map.first_key() + map.size()).maxCoeff(), 32768);
  EXPECT_GE(map.first_key().minCoeff(), -32768);
}

}  // namespace
}  // namespace headway::nav
