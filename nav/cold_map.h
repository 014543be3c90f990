// What has been seen and lies outside of the window around the robot: bricks by their keys, in a hash that
// grows with what was seen and not with the space between.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>

#include "nav/brick.h"
#include "nav/seen_bricks.h"

namespace headway::nav {

/// Bricks of any map read from a file, at most: 550 MB of memory.
inline constexpr std::size_t kMostBricks = 1'000'000;

class ColdMap {
 public:
  static constexpr double kFinest = 1e-4, kCoarsest = 1e3;  ///< edge of a voxel [m]

  /// Holds nothing yet. Throws InputError when the resolution [m] is none.
  explicit ColdMap(double resolution);

  double resolution() const { return resolution_; }
  /// Bricks in which something is known.
  std::size_t size() const { return bricks_.size(); }
  /// Memory held [bytes], without what the allocator adds: proportional to size().
  std::size_t bytes() const;

  /// The values of a brick; null when nothing is known there.
  const BrickValues* find(const BrickKey& key) const;

  /// Keeps the brick in place of what was known there; one in which nothing is known is forgotten. False, and
  /// nothing changes, when the key lies outside of OctoMap's trees.
  bool put(const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values);
  /// Moves the brick out of the map. False, and `values` stays, when nothing is known there.
  bool take(const BrickKey& key, BrickValues& values);
  /// Joins what was seen there at another time: log-odds of independent views add up, within
  /// log_odds::kLowest..kHighest; where only one has seen, it counts. As put otherwise.
  bool merge(const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values);
  /// The brick to change, with all voxels unseen when it was not there. Only for keys within_octree.
  BrickValues& edit(const BrickKey& key);

  /// Calls visit(BrickKey, span of 512 values) for each brick in the order of an octree (tree_order).
  template <class Visit>
  void for_each(Visit&& visit) const {
    const SeenBricks seen(*this);
    for (const PlacedBrick& brick : seen.bricks()) visit(brick_at(brick.order), brick.values);
  }
  /// The same in no particular order, without the time to sort.
  template <class Visit>
  void for_any(Visit&& visit) const {
    for (const auto& [key, values] : bricks_) visit(key, values);
  }

  friend bool operator==(const ColdMap&, const ColdMap&) = default;

 private:
  struct Hash {
    std::size_t operator()(const BrickKey& key) const;
  };
  double resolution_;
  std::unordered_map<BrickKey, BrickValues, Hash> bricks_;
};

/// Whether a voxel of the brick has been seen.
bool anything_known(std::span<const LogOdds, kBrickVoxels> values);

}  // namespace headway::nav
