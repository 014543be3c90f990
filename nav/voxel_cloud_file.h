// Occupied voxels as points of a PLY file, and points of any PLY file as occupied voxels.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>

#include "nav/cold_map.h"
#include "nav/seen_bricks.h"

namespace headway::nav {

/// Writes the middle of each occupied voxel [m] with its log_odds. The file appears whole or not at all.
/// Throws as write_whole does.
void write_voxel_cloud(const SeenBricks& map, const std::filesystem::path& file);
void write_voxel_cloud(const SeenBricks& map, std::ostream& out);

/// Reads a PLY file, text or binary of either order, whose first element is `vertex` with x, y and z [m].
/// Each point is a hit in its voxel; where points have `log_odds`, a voxel gets the largest of its points
/// instead. Points that are not finite are left out. `resolution` [m] is that of the map; without one it is
/// what write_voxel_cloud noted. Throws InputError `file: what` on anything malformed, on points beyond
/// OctoMap's keys, and on more bricks than `most_bricks`.
ColdMap read_voxel_cloud(const std::filesystem::path& file, std::optional<double> resolution = {},
                         std::size_t most_bricks = kMostBricks);
/// The same from a stream; `file` is only named in complaints.
ColdMap read_voxel_cloud(std::istream& in, const std::string& file, std::optional<double> resolution = {},
                         std::size_t most_bricks = kMostBricks);

}  // namespace headway::nav
