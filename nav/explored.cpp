#include "nav/explored.h"

namespace headway::nav {

ExploredSpace explored(const VoxelMap& map) {
  std::size_t unseen = 0, occupied = 0;
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    unseen += map.summary(b).unseen;
    occupied += map.summary(b).occupied;
  }
  const std::size_t empty = map.brick_count() * VoxelMap::kBrickVoxels - unseen - occupied;
  const double volume = map.resolution() * map.resolution() * map.resolution();
  return {volume * static_cast<double>(occupied), volume * static_cast<double>(empty),
          volume * static_cast<double>(unseen)};
}

ExploredFloor explored(const FloorMap& floor) {
  ExploredFloor area;
  const double cell = floor.grid.resolution * floor.grid.resolution;
  for (const Floor f : floor.cells) {
    (f == Floor::kBlocked ? area.blocked : f == Floor::kFree ? area.free : area.unseen) += cell;
  }
  return area;
}

}  // namespace headway::nav
