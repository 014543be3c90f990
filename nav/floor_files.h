// The floor map in map_server's convention: a .pgm (occupied 0, free 254, unknown 205) and a .yaml beside it.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "nav/floor_map.h"

namespace headway::nav {

/// Writes NAME.pgm and NAME.yaml into a folder that exists. Throws as write_whole does.
void write_map_server(const FloorMap& floor, const std::filesystem::path& folder,
                      const std::string& name = "floor");

/// Reads a map_server YAML file and the 8-bit PGM (P5 or P2) it names, mode trinary, with any origin (yaw 0),
/// thresholds and negate. Cells that are not unknown count as seen at `stamp`. Throws InputError on anything
/// malformed.
FloorMap read_map_server(const std::filesystem::path& yaml, Time stamp = Time{});
/// The same from the YAML file's text and the image; `file` is only named in complaints.
FloorMap read_map_server(const std::string& yaml, std::istream& image, const std::string& file,
                         Time stamp = Time{});

}  // namespace headway::nav
