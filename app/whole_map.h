// All that is known, in the window around the robot and aside, as one box: for pictures and questions that
// look at all of it.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>

#include "nav/cold_map.h"
#include "nav/voxel_map.h"

namespace headway::app {

/// The box of the bricks that something is known of; there must be one [m].
Eigen::AlignedBox3d extent_of(const nav::ColdMap& known);

/// In a box around all that `known` knows and the box of `like`, which also says all else but the resolution.
/// Throws InputError as VoxelMapConfig::validate when the box would not fit into memory.
nav::VoxelMap whole_map(const nav::ColdMap& known, const nav::VoxelMapConfig& like);

/// The same for a picture: with voxels twice as wide, and again, until the box has at most `most_voxels` (a
/// byte each). A wide voxel is the surest occupied of the eight that it is made of, so that walls stay.
/// Throws InputError when even voxels of a metre are too many.
nav::VoxelMap whole_map_within(nav::ColdMap known, const nav::VoxelMapConfig& like, std::size_t most_voxels);

}  // namespace headway::app
