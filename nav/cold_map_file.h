// Headway's own map file: every brick as it is, and where within voxels the surfaces lie, with a format
// version and a checksum.
//
// The line "headway map VERSION", then little-endian: resolution [m] (double), number of bricks (64 bits);
// for each brick, in rising order, its tree_order (64 bits) and its 512 values; since version 2, number of
// surface voxels (64 bits), and for each, in rising order, its key (64 bits; see SurfaceVoxel) and weight,
// count, doubt, first and second sums (12 floats), since version 3 those of rays (3 floats); CRC-32 of all
// before.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <utility>

#include "nav/cold_map.h"
#include "nav/seen_bricks.h"
#include "nav/surface_points.h"

namespace headway::nav {

/// The version that is written. Older ones are read, too: version 1 knows no surfaces, version 2 not from
/// which side they were seen.
inline constexpr int kMapFileVersion = 3;

/// A map, and the surfaces that localisation aligns views with.
struct SavedMap {
  SavedMap(ColdMap known) : map(std::move(known)), surfaces(map.resolution()) {}  ///< without surfaces
  ColdMap map;
  SurfacePoints surfaces;
};

void write_map_file(const SeenBricks& map, std::ostream& out);  ///< without surfaces
/// Both have one resolution.
void write_map_file(const SeenBricks& map, const SurfacePoints& surfaces, std::ostream& out);

/// Throws InputError `file: what` on anything malformed or damaged, on more bricks than `most_bricks`, and on
/// a file of another version, saying what to do with it.
ColdMap read_map_file(const std::filesystem::path& file, std::size_t most_bricks = kMostBricks);
/// The same from a stream; `file` is only named in complaints.
ColdMap read_map_file(std::istream& in, const std::string& file, std::size_t most_bricks = kMostBricks);
/// The same with the surfaces.
SavedMap read_saved_map(const std::filesystem::path& file, std::size_t most_bricks = kMostBricks);
SavedMap read_saved_map(std::istream& in, const std::string& file, std::size_t most_bricks = kMostBricks);

}  // namespace headway::nav
