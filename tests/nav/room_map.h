// A voxel map around SyntheticRoom, and a walk through what it knows.
#pragma once

#include "hal/angle.h"
#include "nav/voxel_map.h"

namespace headway::nav {

inline VoxelMap room_map(double resolution = 0.05) {
  VoxelMapConfig config;
  config.resolution = resolution;
  config.lowest = {-2.8, -2.8, -0.4};
  config.highest = {2.8, 2.8, 2.8};
  return VoxelMap(config);
}

template <class Visit>
void for_each_known(const VoxelMap& map, Visit visit) {
  for (int z = 0; z < map.size().z(); ++z) {
    for (int y = 0; y < map.size().y(); ++y) {
      for (int x = 0; x < map.size().x(); ++x) {
        if (map.at({x, y, z}) != Voxel::kUnseen) visit(VoxelMap::Index(x, y, z));
      }
    }
  }
}

}  // namespace headway::nav
