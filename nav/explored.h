// How much of the space and of the floor has been seen.
#pragma once

#include "nav/cold_map.h"
#include "nav/floor_map.h"
#include "nav/voxel_map.h"

namespace headway::nav {

/// Volumes [m^3] of the whole box.
struct ExploredSpace {
  double occupied = 0, empty = 0, unseen = 0;
};
ExploredSpace explored(const VoxelMap& map);
/// Of bricks with these keys.
ExploredSpace explored(const ColdMap& map, const BrickRange& box);

/// Areas [m^2] of the whole grid.
struct ExploredFloor {
  double blocked = 0, free = 0, unseen = 0;
};
ExploredFloor explored(const FloorMap& floor);

}  // namespace headway::nav
