#include "nav/solid_boxes.h"

#include <array>
#include <cstddef>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "synthetic_room.h"

namespace headway::nav {
namespace {

using Brick = std::array<LogOdds, VoxelMap::kBrickVoxels>;

RC_GTEST_PROP(SolidBoxes, HoldEachOccupiedVoxelOnceAndNoOther, ()) {
  std::mt19937_64 random(static_cast<std::uint64_t>(*rc::gen::inRange(0, 1 << 20)));
  const double share = *rc::gen::element(0.0, 0.05, 0.5, 0.95, 1.0);
  Brick brick;
  for (LogOdds& value : brick)
    value = static_cast<LogOdds>(uniform(random) < share ? 70 * uniform(random) : -1 - 127 * uniform(random));
  std::array<int, VoxelMap::kBrickVoxels> held{};
  for (const SolidBox8& box : SolidBoxes(brick))
    for (int z = box.low[2]; z < box.high[2]; ++z)
      for (int y = box.low[1]; y < box.high[1]; ++y)
        for (int x = box.low[0]; x < box.high[0]; ++x)
          ++held[static_cast<std::size_t>(VoxelMap::in_brick(x, y, z))];
  for (std::size_t i = 0; i < brick.size(); ++i)
    RC_ASSERT(held[i] == (voxel_of(brick[i]) == Voxel::kOccupied ? 1 : 0));
}

/// `value(x, y, z)` everywhere.
template <class Value>
Brick brick_of(const Value& value) {
  Brick brick;
  for (int i = 0; i < VoxelMap::kBrickVoxels; ++i)
    brick[static_cast<std::size_t>(VoxelMap::in_brick(i & 7, i >> 3 & 7, i >> 6))] =
        value(i & 7, i >> 3 & 7, i >> 6);
  return brick;
}

std::ptrdiff_t boxes_of(const Brick& brick) {
  const SolidBoxes boxes(brick);
  return boxes.end() - boxes.begin();
}

TEST(SolidBoxes, TakeAWallAsOneBox) {
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_EQ(boxes_of(brick_of([&](int x, int y, int z) {
                return (axis == 0 ? x : axis == 1 ? y : z) == 5 ? log_odds::kHit : log_odds::kMiss;
              })),
              1)
        << "across axis " << axis;
}

TEST(SolidBoxes, HaveRoomForAChessboard) {
  EXPECT_EQ(boxes_of(brick_of(
                [](int x, int y, int z) { return (x ^ y ^ z) & 1 ? log_odds::kHit : log_odds::kUnseen; })),
            256);
}

}  // namespace
}  // namespace headway::nav
