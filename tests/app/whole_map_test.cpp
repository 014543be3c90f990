#include "app/whole_map.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/nav/any_cold_map.h"

namespace headway::app {
namespace {

using nav::BrickKey, nav::BrickValues, nav::ColdMap, nav::Voxel, nav::VoxelMap;

nav::VoxelMapConfig small_box() {
  nav::VoxelMapConfig config;
  config.lowest = {-0.5, -0.5, 0};
  config.highest = {0.5, 0.5, 0.5};
  return config;
}

/// A map whose bricks lie near each other.
ColdMap any_near_map() {
  ColdMap map(0.05);
  const auto along = [] { return *rc::gen::inRange(-20, 20); };
  const int bricks = *rc::gen::inRange(0, 12);
  for (int b = 0; b < bricks; ++b) map.put({along(), along(), along()}, nav::any_brick());
  return map;
}

Eigen::Vector3d centre(const BrickKey& key, int place, double resolution) {
  const nav::VoxelOfBrick in = nav::voxel_of_brick(place);
  return resolution *
         (8 * Eigen::Vector3d(key.x, key.y, key.z) + Eigen::Vector3d(in.x + 0.5, in.y + 0.5, in.z + 0.5));
}

RC_GTEST_PROP(WholeMap, KnowsWhatIsKnownAndNothingElse, ()) {
  const ColdMap known = any_near_map();
  const VoxelMap whole = whole_map(known, small_box());
  std::size_t seen = 0, bricks_seen = 0;
  known.for_any([&](const BrickKey& key, const BrickValues& values) {
    for (int i = 0; i < nav::kBrickVoxels; ++i) {
      const nav::LogOdds value = values[static_cast<std::size_t>(i)];
      RC_ASSERT(whole.value(whole.index(centre(key, i, 0.05))) == value);
      seen += value != nav::log_odds::kUnseen;
    }
  });
  for (std::size_t b = 0; b < whole.brick_count(); ++b)
    bricks_seen += nav::kBrickVoxels - whole.summary(b).unseen;
  RC_ASSERT(seen == bricks_seen);
}

RC_GTEST_PROP(WholeMap, KeepsWallsAndItsBoundWhenItIsShownCoarser, ()) {
  const ColdMap known = any_near_map();
  const std::size_t most = *rc::gen::element<std::size_t>(40'000, 200'000, 5'000'000);
  const VoxelMap shown = whole_map_within(known, small_box(), most);
  RC_ASSERT(shown.brick_count() * nav::kBrickVoxels <= most);
  known.for_any([&](const BrickKey& key, const BrickValues& values) {
    for (int i = 0; i < nav::kBrickVoxels; ++i) {
      const Voxel was = nav::voxel_of(values[static_cast<std::size_t>(i)]);
      const Voxel is = shown.at_point(centre(key, i, 0.05));
      if (was == Voxel::kOccupied) RC_ASSERT(is == Voxel::kOccupied);
      if (was == Voxel::kEmpty) RC_ASSERT(is != Voxel::kUnseen);
    }
  });
}

TEST(WholeMap, OfFarAwayPlacesIsRefusedWholeAndShownCoarser) {
  ColdMap known(0.05);
  BrickValues values;
  values.fill(17);
  known.put({0, 0, 0}, values);
  known.put({4000, 4000, 0}, values);
  EXPECT_THROW(whole_map(known, small_box()), InputError);
  const VoxelMap shown = whole_map_within(known, small_box(), 64'000'000);
  EXPECT_EQ(shown.at_point({1600.1, 1600.1, 0.1}), Voxel::kOccupied);
  EXPECT_EQ(shown.at_point({800, 800, 0.1}), Voxel::kUnseen);
}

}  // namespace
}  // namespace headway::app
