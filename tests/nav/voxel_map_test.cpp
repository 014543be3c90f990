#include "nav/voxel_map.h"

#include <cmath>
#include <map>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"

namespace headway::nav {
namespace {

using Index = VoxelMap::Index;

double metres(double lowest, double highest) {
  return lowest + (highest - lowest) * *rc::gen::inRange(0, 1 << 20) / static_cast<double>(1 << 20);
}

VoxelMapConfig any_box() {
  VoxelMapConfig config;
  config.resolution = *rc::gen::element(0.05, 0.02, 0.1, 0.033);
  for (int k = 0; k < 3; ++k) {
    config.lowest[k] = metres(-3, 2);
    config.highest[k] = config.lowest[k] + metres(0.05, 1.5);
  }
  return config;
}

VoxelMap small_map() {
  VoxelMapConfig config;
  config.lowest = {-0.5, -0.5, -0.5};
  config.highest = {0.5, 0.5, 0.5};
  return VoxelMap(config);
}

RC_GTEST_PROP(VoxelMap, CoversTheBoxAskedForWithWholeBricksOnOctomapsRaster, ()) {
  const VoxelMapConfig config = any_box();
  const VoxelMap map(config);
  RC_ASSERT((map.lowest().array() <= config.lowest.array() + 1e-6).all());
  RC_ASSERT((map.highest().array() >= config.highest.array() - 1e-6).all());
  for (int k = 0; k < 3; ++k) {
    RC_ASSERT(map.first_key()[k] % 8 == 0);
    RC_ASSERT(map.size()[k] % 8 == 0);
    RC_ASSERT(config.lowest[k] - map.lowest()[k] < 8.001 * config.resolution);
    RC_ASSERT(map.highest()[k] - config.highest[k] < 8.001 * config.resolution);
  }
}

RC_GTEST_PROP(VoxelMap, FindsEachPointInTheVoxelWhoseCentreIsWithinHalfAnEdge, ()) {
  const VoxelMap map(any_box());
  Eigen::Vector3d point;
  for (int k = 0; k < 3; ++k) point[k] = metres(map.lowest()[k] - 0.5, map.highest()[k] + 0.5);
  const Index i = map.index(point);
  RC_ASSERT((map.centre(i) - point).cwiseAbs().maxCoeff() <= map.resolution() * 0.5 + 1e-9);
  RC_ASSERT(map.index(map.centre(i)) == i);
  const bool inside =
      (point.array() >= map.lowest().array()).all() && (point.array() < map.highest().array()).all();
  RC_ASSERT(map.contains(i) == inside);
}

RC_GTEST_PROP(VoxelMap, HoldsWhatWasSetAndCountsItPerBrick, ()) {
  VoxelMap map = small_map();
  std::map<std::tuple<int, int, int>, LogOdds> model;
  const int changes = *rc::gen::inRange(0, 200);
  for (int c = 0; c < changes; ++c) {
    const Index i(*rc::gen::inRange(0, map.size().x()), *rc::gen::inRange(0, map.size().y()),
                  *rc::gen::inRange(0, map.size().z()));
    const auto value = static_cast<LogOdds>(*rc::gen::inRange(-41, 71));
    const LogOdds stored = value == -41 ? log_odds::kUnseen : value;
    map.set(i, stored, at_seconds(c));
    model[{i.x(), i.y(), i.z()}] = stored;
  }
  std::vector<int> unseen(map.brick_count()), occupied(map.brick_count());
  for (int z = 0; z < map.size().z(); ++z) {
    for (int y = 0; y < map.size().y(); ++y) {
      for (int x = 0; x < map.size().x(); ++x) {
        const auto found = model.find({x, y, z});
        const LogOdds expected = found == model.end() ? log_odds::kUnseen : found->second;
        RC_ASSERT(map.value({x, y, z}) == expected);
        const std::size_t brick = map.brick_index({x / 8, y / 8, z / 8});
        RC_ASSERT(map.values(brick)[static_cast<std::size_t>(VoxelMap::in_brick(x % 8, y % 8, z % 8))] ==
                  expected);
        unseen[brick] += expected == log_odds::kUnseen;
        occupied[brick] += map.at({x, y, z}) == Voxel::kOccupied;
      }
    }
  }
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    RC_ASSERT(map.summary(b).unseen == unseen[b]);
    RC_ASSERT(map.summary(b).occupied == occupied[b]);
    RC_ASSERT(map.brick_index(map.brick_at(b)) == b);
  }
}

TEST(VoxelMap, StartsUnseenAndIsUnseenOutside) {
  const VoxelMap map = small_map();
  EXPECT_EQ(map.at({3, 3, 3}), Voxel::kUnseen);
  EXPECT_EQ(map.at({-1, 0, 0}), Voxel::kUnseen);
  EXPECT_EQ(map.at_point({100, 0, 0}), Voxel::kUnseen);
  EXPECT_EQ(map.floor_seen_at(0, 0), kNever);
  EXPECT_EQ(map.floor_seen_at(-1, 9999), kNever);
  EXPECT_EQ(map.summary(0).changed, kNever);
}

TEST(VoxelMap, CallsAVoxelOccupiedFromEvenOddsOnAsOctomapDoes) {
  EXPECT_EQ(voxel_of(log_odds::kUnseen), Voxel::kUnseen);
  EXPECT_EQ(voxel_of(-1), Voxel::kEmpty);
  EXPECT_EQ(voxel_of(0), Voxel::kOccupied);
}

TEST(VoxelMap, StampsOnlyTheBrickThatChanged) {
  VoxelMap map = small_map();
  map.set({9, 1, 1}, 17, at_seconds(3));
  const std::size_t changed = map.brick_index({1, 0, 0});
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    EXPECT_EQ(map.summary(b).changed, b == changed ? at_seconds(3) : kNever);
  }
}

TEST(VoxelMap, TakesTheLayersAroundFloorHeightAsTheFoot) {
  const VoxelMap map = small_map();
  for (int z = 0; z < map.size().z(); ++z) {
    const bool near_floor = std::abs(map.centre({0, 0, z}).z()) <= 0.1;
    EXPECT_EQ(z >= map.foot_begin() && z < map.foot_end(), near_floor) << z;
  }
  EXPECT_EQ(map.foot_end() - map.foot_begin(), 4);
}

TEST(VoxelMap, RemembersWhenTheFloorWasSeen) {
  VoxelMap map = small_map();
  map.see_floor(2, 5, at_seconds(7));
  EXPECT_EQ(map.floor_seen_at(2, 5), at_seconds(7));
  EXPECT_EQ(map.floor_seen_at(5, 2), kNever);
  EXPECT_LT(at_seconds(-1e6), kNever + seconds(9e9)) << "the age of what was never seen must not overflow";
  EXPECT_GT(at_seconds(1e6) - kNever, seconds(1e9));
}

TEST(VoxelMap, RefusesBoxesThatCannotBe) {
  const auto complaint = [](auto change) {
    VoxelMapConfig config;
    change(config);
    try {
      VoxelMap map(config);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  using testing::HasSubstr;
  EXPECT_THAT(complaint([](auto& c) { c.resolution = 0; }), HasSubstr("resolution"));
  EXPECT_THAT(complaint([](auto& c) { c.resolution = std::nan(""); }), HasSubstr("resolution"));
  EXPECT_THAT(complaint([](auto& c) { c.lowest.x() = 9; }), HasSubstr("enclose no box"));
  EXPECT_THAT(complaint([](auto& c) { c.highest.z() = std::nan(""); }), HasSubstr("enclose no box"));
  EXPECT_THAT(complaint([](auto& c) { c.highest.x() = 1e4; }), HasSubstr("OctoMap"));
  EXPECT_THAT(complaint([](auto& c) { c.lowest.setConstant(-100), c.highest.setConstant(100); }),
              HasSubstr("3e8 voxels"));
  EXPECT_THAT(complaint([](auto& c) { c.floor_band = -1; }), HasSubstr("floor band"));
  EXPECT_THAT(complaint([](auto& c) { c.obstacle_height = 0; }), HasSubstr("obstacle height"));
}

}  // namespace
}  // namespace headway::nav
