// The bricks of a map in which something is known, in the order of an octree: what writers of maps go
// through.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nav/brick_order.h"

namespace headway::nav {

class ColdMap;
class VoxelMap;

/// A brick of a map and its place among all bricks (tree_order).
struct PlacedBrick {
  std::uint64_t order;
  std::span<const LogOdds, kBrickVoxels> values;
};

/// Points into the map, which must stay as it is meanwhile.
class SeenBricks {
 public:
  SeenBricks(const VoxelMap& map);  // not explicit: writers take either map
  SeenBricks(const ColdMap& map);

  double resolution() const { return resolution_; }
  std::span<const PlacedBrick> bricks() const { return bricks_; }

 private:
  void sort();

  double resolution_;
  std::vector<PlacedBrick> bricks_;
};

}  // namespace headway::nav
