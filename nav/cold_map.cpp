#include "nav/cold_map.h"

#include <algorithm>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::nav {

ColdMap::ColdMap(double resolution) : resolution_(resolution) {
  if (!(resolution >= kFinest && resolution <= kCoarsest)) {
    throw InputError(fmt::format("resolution: {} m, expected {} to {} m", resolution, kFinest, kCoarsest));
  }
}

// The order along the tree is one number per brick; its bits are mixed (Fibonacci hashing), for the library's
// buckets are the remainders.
std::size_t ColdMap::Hash::operator()(const BrickKey& key) const {
  return static_cast<std::size_t>(tree_order(key) * 0x9E3779B97F4A7C15U >> 16);
}

std::size_t ColdMap::bytes() const {
  struct Node {
    void* next;
    std::pair<const BrickKey, BrickValues> brick;
    std::size_t hash;
  };
  return bricks_.size() * sizeof(Node) + bricks_.bucket_count() * sizeof(void*);
}

const BrickValues* ColdMap::find(const BrickKey& key) const {
  const auto found = bricks_.find(key);
  return found == bricks_.end() ? nullptr : &found->second;
}

bool ColdMap::put(const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values) {
  if (!within_octree(key)) return false;
  if (anything_known(values)) {
    std::copy(values.begin(), values.end(), bricks_.try_emplace(key).first->second.begin());
  } else {
    bricks_.erase(key);
  }
  return true;
}

bool ColdMap::take(const BrickKey& key, BrickValues& values) {
  const auto found = bricks_.find(key);
  if (found == bricks_.end()) return false;
  values = found->second;
  bricks_.erase(found);
  return true;
}

bool ColdMap::merge(const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values) {
  if (!within_octree(key)) return false;
  if (!anything_known(values)) return true;
  BrickValues& brick = edit(key);
  for (std::size_t i = 0; i < values.size(); ++i) {
    LogOdds& known = brick[i];
    if (values[i] == log_odds::kUnseen) continue;
    const int sum = known == log_odds::kUnseen ? values[i] : known + values[i];
    known = static_cast<LogOdds>(std::clamp<int>(sum, log_odds::kLowest, log_odds::kHighest));
  }
  return true;
}

BrickValues& ColdMap::edit(const BrickKey& key) {
  const auto [place, is_new] = bricks_.try_emplace(key);
  if (is_new) place->second.fill(log_odds::kUnseen);
  return place->second;
}

bool anything_known(std::span<const LogOdds, kBrickVoxels> values) {
  return std::any_of(values.begin(), values.end(), [](LogOdds v) { return v != log_odds::kUnseen; });
}

}  // namespace headway::nav
