// Headway's own map file: every brick as it is, with a format version and a checksum.
//
// The line "headway map VERSION", then little-endian: resolution [m] (double), number of bricks (64 bits);
// for each brick, in rising order, its tree_order (64 bits) and its 512 values; CRC-32 of all before.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <string>

#include "nav/cold_map.h"
#include "nav/seen_bricks.h"

namespace headway::nav {

/// The only version that is written and read.
inline constexpr int kMapFileVersion = 1;

void write_map_file(const SeenBricks& map, std::ostream& out);

/// Throws InputError `file: what` on anything malformed or damaged, on more bricks than `most_bricks`, and on
/// a file of another version, saying what to do with it.
ColdMap read_map_file(const std::filesystem::path& file, std::size_t most_bricks = kMostBricks);
/// The same from a stream; `file` is only named in complaints.
ColdMap read_map_file(std::istream& in, const std::string& file, std::size_t most_bricks = kMostBricks);

}  // namespace headway::nav
