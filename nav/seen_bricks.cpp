#include "nav/seen_bricks.h"

#include <algorithm>

#include "nav/cold_map.h"
#include "nav/voxel_map.h"

namespace headway::nav {

SeenBricks::SeenBricks(const VoxelMap& map) : resolution_(map.resolution()) {
  const VoxelMap::Index first = map.first_key() / kBrickEdge;
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    if (map.summary(b).unseen == kBrickVoxels) continue;
    const VoxelMap::Index key = first + map.brick_at(b);
    bricks_.push_back({tree_order({key.x(), key.y(), key.z()}), map.values(b)});
  }
  sort();
}

SeenBricks::SeenBricks(const ColdMap& map) : resolution_(map.resolution()) {
  bricks_.reserve(map.size());
  map.for_any([&](const BrickKey& key, const BrickValues& values) {
    bricks_.push_back({tree_order(key), values});
  });
  sort();
}

void SeenBricks::sort() {
  std::sort(bricks_.begin(), bricks_.end(),
            [](const PlacedBrick& a, const PlacedBrick& b) { return a.order < b.order; });
}

}  // namespace headway::nav
