#include "nav/cold_map.h"

#include <map>
#include <optional>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <rapidcheck/gtest.h>

#include "any_cold_map.h"
#include "hal/error.h"

namespace headway::nav {
namespace {

BrickValues full(LogOdds value) {
  BrickValues values;
  values.fill(value);
  return values;
}

/// What independent views say together, voxel by voxel.
LogOdds joined(LogOdds a, LogOdds b) {
  if (a == log_odds::kUnseen) return b;
  if (b == log_odds::kUnseen) return a;
  return static_cast<LogOdds>(std::min(70, std::max(-40, a + b)));
}

// Oracle: a std::map that does the same the slow way.
RC_GTEST_PROP(ColdMap, KeepsGivesBackAndJoinsBricksAsAPlainTableDoes, ()) {
  ColdMap map(0.05);
  std::map<BrickKey, BrickValues> plain;
  std::vector<BrickKey> keys;
  for (int k = 0; k < 4; ++k) keys.push_back(any_key());
  for (int step = 0; step < 20; ++step) {
    const BrickKey key = *rc::gen::elementOf(keys);
    const BrickValues values = any_brick();
    const int what = *rc::gen::inRange(0, 3);
    if (what == 0) {
      RC_ASSERT(map.put(key, values));
      plain[key] = values;
    } else if (what == 1) {
      RC_ASSERT(map.merge(key, values));
      auto& known = plain.try_emplace(key, full(log_odds::kUnseen)).first->second;
      for (std::size_t i = 0; i < values.size(); ++i) known[i] = joined(known[i], values[i]);
    } else {
      BrickValues taken = full(1);
      const bool is_there = plain.contains(key);
      RC_ASSERT(map.take(key, taken) == is_there);
      RC_ASSERT(taken == (is_there ? plain[key] : full(1)));
      plain.erase(key);
    }
    std::erase_if(plain, [](const auto& brick) { return !anything_known(brick.second); });
    RC_ASSERT(map.size() == plain.size());
    for (const BrickKey& k : keys) {
      const BrickValues* found = map.find(k);
      RC_ASSERT((found != nullptr) == plain.contains(k));
      if (found != nullptr) RC_ASSERT(*found == plain[k]);
    }
  }
}

// Oracle: OctoMap's own iterator over the leaves of a tree that holds one voxel of each brick.
RC_GTEST_PROP(ColdMap, IsGoneThroughInTheOrderOfOctomapsLeaves, ()) {
  const ColdMap map = any_cold_map();
  octomap::OcTree tree(map.resolution());
  std::size_t count = 0;
  map.for_any([&](const BrickKey& key, const BrickValues&) {
    ++count;
    const auto middle = [](std::int32_t k) { return static_cast<octomap::key_type>(8 * k + 32768 + 4); };
    tree.updateNode(octomap::OcTreeKey(middle(key.x), middle(key.y), middle(key.z)), true);
  });
  RC_ASSERT(count == map.size());
  auto leaf = tree.begin_leafs();
  map.for_each([&](const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values) {
    const auto in_tree = leaf.getKey();
    const auto brick = [&](unsigned axis) { return (static_cast<int>(in_tree[axis]) - 32768) >> 3; };
    RC_ASSERT(key == (BrickKey{brick(0), brick(1), brick(2)}));
    RC_ASSERT(std::equal(values.begin(), values.end(), map.find(key)->begin()));
    ++leaf;
  });
  RC_ASSERT(leaf == tree.end_leafs());
}

RC_GTEST_PROP(BrickOrder, NamesEachBrickOnce, ()) {
  const BrickKey key = any_key();
  RC_ASSERT(brick_at(tree_order(key)) == key);
  RC_ASSERT(tree_order(key) < std::uint64_t{1} << 39);
}

TEST(ColdMap, ForgetsBricksInWhichNothingIsKnown) {
  ColdMap map(0.05);
  EXPECT_TRUE(map.put({1, 2, 3}, full(-8)));
  EXPECT_TRUE(map.put({1, 2, 3}, full(log_odds::kUnseen)));
  EXPECT_TRUE(map.merge({1, 2, 3}, full(log_odds::kUnseen)));
  EXPECT_EQ(map.size(), 0U);
}

TEST(ColdMap, RefusesWhatOctomapsKeysCannotName) {
  ColdMap map(0.05);
  EXPECT_TRUE(map.put({-4096, 4095, 0}, full(5)));
  for (const BrickKey& key : {BrickKey{4096, 0, 0}, BrickKey{0, -4097, 0}, BrickKey{0, 0, 1 << 30}}) {
    EXPECT_FALSE(map.put(key, full(5)));
    EXPECT_FALSE(map.merge(key, full(5)));
  }
  EXPECT_EQ(map.size(), 1U);
  for (const double resolution : {0.0, -0.05, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(ColdMap{resolution}, InputError);
  }
}

// The space between does not count: two bricks at opposite ends of the tree take what two neighbours take.
TEST(ColdMap, TakesMemoryInProportionToWhatWasSeen) {
  ColdMap near(0.05), far(0.05);
  near.put({0, 0, 0}, full(5));
  near.put({1, 0, 0}, full(5));
  far.put({-4096, -4096, -4096}, full(5));
  far.put({4095, 4095, 4095}, full(5));
  EXPECT_EQ(near.bytes(), far.bytes());
  ColdMap large(0.05);
  for (std::int32_t x = 0; x < 10000; ++x) large.put({x % 100, x / 100, 7}, full(5));
  EXPECT_GT(large.bytes(), 10000U * kBrickVoxels);
  EXPECT_LT(large.bytes(), 10000U * kBrickVoxels * 5 / 4);
}

}  // namespace
}  // namespace headway::nav
