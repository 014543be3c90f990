#include "nav/explored.h"

namespace headway::nav {

namespace {

/// [m^3] from numbers of voxels.
ExploredSpace space(double resolution, std::size_t all, std::size_t unseen, std::size_t occupied) {
  const double volume = resolution * resolution * resolution;
  return {volume * static_cast<double>(occupied), volume * static_cast<double>(all - unseen - occupied),
          volume * static_cast<double>(unseen)};
}

}  // namespace

ExploredSpace explored(const VoxelMap& map) {
  std::size_t unseen = 0, occupied = 0;
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    unseen += map.summary(b).unseen;
    occupied += map.summary(b).occupied;
  }
  return space(map.resolution(), map.brick_count() * kBrickVoxels, unseen, occupied);
}

ExploredSpace explored(const ColdMap& map, const BrickRange& box) {
  const Eigen::Vector3i size = box.end - box.first;
  const std::size_t all = static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) *
                          static_cast<std::size_t>(size.z()) * kBrickVoxels;
  std::size_t known = 0, occupied = 0;
  map.for_any([&](const BrickKey& key, const BrickValues& values) {
    const Eigen::Array3i at(key.x, key.y, key.z);
    if ((at < box.first.array()).any() || (at >= box.end.array()).any()) return;
    for (const LogOdds value : values) {
      known += value != log_odds::kUnseen;
      occupied += value >= log_odds::kOccupied;
    }
  });
  return space(map.resolution(), all, all - known, occupied);
}

ExploredFloor explored(const FloorMap& floor) {
  ExploredFloor area;
  const double cell = floor.grid.resolution * floor.grid.resolution;
  for (const Floor f : floor.cells) {
    (is_occupied(f) ? area.blocked : f == Floor::kFree ? area.free : area.unseen) += cell;
  }
  return area;
}

}  // namespace headway::nav
