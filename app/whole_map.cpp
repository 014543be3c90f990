#include "app/whole_map.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace headway::app {

namespace {

constexpr int kEdge = nav::VoxelMap::kBrickEdge;

Eigen::Vector3i place_of(const nav::BrickKey& key) { return {key.x, key.y, key.z}; }

/// The box of `like` and all that is known. Nothing known leaves it as it is.
nav::VoxelMapConfig around(const nav::ColdMap& known, nav::VoxelMapConfig config) {
  config.resolution = known.resolution();
  if (known.size() == 0) return config;
  const Eigen::AlignedBox3d extent = extent_of(known);
  config.lowest = config.lowest.cwiseMin(extent.min());
  config.highest = config.highest.cwiseMax(extent.max());
  return config;
}

/// Voxels twice as wide. Unseen is the lowest value of all, so that the highest is the surest occupied.
nav::ColdMap twice_as_wide(const nav::ColdMap& known) {
  nav::ColdMap wide(2 * known.resolution());
  known.for_any([&](const nav::BrickKey& key, const nav::BrickValues& values) {
    nav::BrickValues& into = wide.edit({key.x >> 1, key.y >> 1, key.z >> 1});
    const Eigen::Vector3i corner = kEdge / 2 * Eigen::Vector3i(key.x & 1, key.y & 1, key.z & 1);
    for (int i = 0; i < nav::VoxelMap::kBrickVoxels; ++i) {
      const nav::VoxelOfBrick from = nav::voxel_of_brick(i);
      nav::LogOdds& to = into[static_cast<std::size_t>(
          nav::in_brick(corner.x() + from.x / 2, corner.y() + from.y / 2, corner.z() + from.z / 2))];
      to = std::max(to, values[static_cast<std::size_t>(i)]);
    }
  });
  return wide;
}

std::size_t voxels_of(const nav::VoxelMapConfig& config) {
  const nav::BrickRange box = nav::bricks_in(config);
  const Eigen::Vector3d bricks = (box.end - box.first).cast<double>();
  return static_cast<std::size_t>(bricks.prod() * nav::VoxelMap::kBrickVoxels);
}

}  // namespace

Eigen::AlignedBox3d extent_of(const nav::ColdMap& known) {
  Eigen::Vector3i first = Eigen::Vector3i::Constant(std::numeric_limits<int>::max()), last = -first;
  known.for_any([&](const nav::BrickKey& key, const nav::BrickValues&) {
    first = first.cwiseMin(place_of(key));
    last = last.cwiseMax(place_of(key));
  });
  const double brick = known.resolution() * kEdge;
  return {brick * first.cast<double>(), brick * (last.array() + 1).cast<double>().matrix()};
}

nav::VoxelMap whole_map(const nav::ColdMap& known, const nav::VoxelMapConfig& like) {
  nav::VoxelMap map(around(known, like));
  const Eigen::Vector3i first = map.first_key() / kEdge;
  known.for_any([&](const nav::BrickKey& key, const nav::BrickValues& values) {
    const std::size_t brick = map.brick_index(place_of(key) - first);
    std::copy(values.begin(), values.end(), map.edit(brick).begin());
    map.settle(brick, Time{});
  });
  return map;
}

nav::VoxelMap whole_map_within(nav::ColdMap known, const nav::VoxelMapConfig& like, std::size_t most_voxels) {
  while (voxels_of(around(known, like)) > most_voxels) known = twice_as_wide(std::as_const(known));
  return whole_map(known, like);
}

}  // namespace headway::app
