// How much of the space and of the floor has been seen.
#pragma once

#include "nav/floor_map.h"
#include "nav/voxel_map.h"

namespace headway::nav {

/// Volumes [m^3] of the whole box.
struct ExploredSpace {
  double occupied = 0, empty = 0, unseen = 0;
};
ExploredSpace explored(const VoxelMap& map);

/// Areas [m^2] of the whole grid.
struct ExploredFloor {
  double blocked = 0, free = 0, unseen = 0;
};
ExploredFloor explored(const FloorMap& floor);

}  // namespace headway::nav
