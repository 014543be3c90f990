// Between the floor map and a map of voxels: what stands on the floor as columns, and back.
#pragma once

#include <cstddef>

#include "nav/cold_map.h"
#include "nav/floor_map.h"

namespace headway::nav {

/// A column for each cell that is not unseen: the floor below z = 0 as an occupied voxel, and above it, up to
/// `height` [m], occupied voxels where the cell is blocked and empty ones where it is free. Voxels are as
/// wide as cells, and cells go to the columns nearest to them. Throws InputError when the floor lies beyond
/// OctoMap's keys, the height is not positive, or the map would hold more bricks than `most_bricks`.
ColdMap raise_floor(const FloorMap& floor, double height, std::size_t most_bricks = kMostBricks);

/// The floor map of all that was seen, as floor_map, where the floor lies at z = `floor_height` [m] (to the
/// next voxel). Throws InputError when nothing was seen there, or the floor is larger than a VoxelMap may be.
FloorMap floor_below(const ColdMap& map, const FloorMapConfig& config = {}, double floor_height = 0);

}  // namespace headway::nav
