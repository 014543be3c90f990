// Grid maps of the Moving AI benchmarks (https://movingai.com/benchmarks/formats.html).
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "nav/floor_map.h"

namespace headway::nav {

/// Reads a .map file of type octile, a cell being `resolution` [m] wide; the file's last row lies at y = 0,
/// its first column at x = 0. Free: '.', 'G' and swamp 'S'; blocked: '@', 'O', 'T' and water 'W', which
/// cannot be entered from the land. All cells count as seen at `stamp`. Throws InputError
/// `file:line: what, expected what`.
FloorMap read_moving_ai(const std::filesystem::path& file, double resolution, Time stamp = Time{});
/// The same from the file's text; `file` is only named in complaints.
FloorMap read_moving_ai(std::istream& text, const std::string& file, double resolution, Time stamp = Time{});

}  // namespace headway::nav
