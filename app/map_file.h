// A saved map, read for the commands that ask it something.
#pragma once

#include <filesystem>

#include "nav/voxel_map.h"

namespace headway::app {

/// The map of a file (.hmap, or OctoMap's .bt or .ot), in a box around all that it knows and the box of
/// `like`, which also says all else but the resolution. Throws InputError `file: what, expected what`.
nav::VoxelMap read_map(const std::filesystem::path& file, const nav::VoxelMapConfig& like);

}  // namespace headway::app
