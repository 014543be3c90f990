// The leaves of an octree, of whatever size, turned into the bricks of a map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "nav/cold_map.h"

namespace headway::nav {

/// A cube of voxels by OctoMap's keys: that of its lowest corner, 0..65535 each, and its edge, a power of
/// two.
struct OctreeCube {
  static constexpr int kRootEdge = 65536;

  std::int32_t x = 0, y = 0, z = 0;
  std::int32_t edge = kRootEdge;

  /// Child i lies at x + 2 y + 4 z.
  constexpr OctreeCube child(unsigned i) const {
    const std::int32_t half = edge / 2;
    const auto along = [&](unsigned axis) { return (i >> axis & 1) != 0 ? half : 0; };
    return {x + along(0), y + along(1), z + along(2), half};
  }
};

/// The log-odds of a leaf in units, within what maps hold; the leaf stays on its side of occupied. Only for
/// finite numbers.
LogOdds units_of(double log_odds, bool occupied);

class OctreeLeaves {
 public:
  /// `source` is named in complaints. A leaf above a brick stands for many, hence the bound.
  OctreeLeaves(double resolution, std::string source, std::size_t most_bricks);

  /// Throws InputError when the map would hold too many bricks.
  void add(const OctreeCube& cube, LogOdds value);

  ColdMap take() && { return std::move(map_); }

 private:
  BrickValues& brick(const BrickKey& key);
  void make_room(std::size_t bricks) const;

  ColdMap map_;
  std::string source_;
  std::size_t most_bricks_;
  BrickKey last_key_{kBrickReach, 0, 0};  ///< leaves of a brick come in a row
  BrickValues* last_ = nullptr;
};

}  // namespace headway::nav
