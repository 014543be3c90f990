// A saved map, read for the commands that ask it something.
#pragma once

#include <filesystem>

#include "nav/cold_map.h"
#include "nav/cold_map_file.h"
#include "nav/voxel_map.h"

namespace headway::app {

/// The map of a file (.hmap, or OctoMap's .bt or .ot), in a box around all that it knows and the box of
/// `like`, which also says all else but the resolution. Throws InputError `file: what, expected what`.
nav::VoxelMap read_map(const std::filesystem::path& file, const nav::VoxelMapConfig& like);

/// The same with the surfaces that localisation aligns views with, which only a .hmap has.
nav::SavedMap read_saved(const std::filesystem::path& file);

/// The same in steps, for who has to look at what is known before there is a box around it.
nav::ColdMap read_known(const std::filesystem::path& file);
/// Throws InputError that names `file` where the box is too large.
nav::VoxelMap voxels_of(const nav::ColdMap& known, const nav::VoxelMapConfig& like,
                        const std::filesystem::path& file);

}  // namespace headway::app
