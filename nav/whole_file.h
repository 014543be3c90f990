// Files that appear whole or not at all, so that a reader never meets half a map; and the way into a file.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <iosfwd>

namespace headway::nav {

/// Whether it is there, and nothing that another file may take the place of: a device, a pipe, a socket, or
/// what this program's stdout or stderr goes to (/dev/stdout).
bool is_stream(const std::filesystem::path& file);

/// Writes FILE.part with `write` and renames it to `file`, or to what that links to. Throws when that fails,
/// and leaves what was there before: InputError where its folder is not there or it is a folder itself, Error
/// where the machine does not let it be written or has no room for it. A stream is written to as it stands.
void write_whole(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

/// Opens a file for reading. Throws InputError when there is none, or it is a folder or a device.
std::ifstream open_whole(const std::filesystem::path& file);

}  // namespace headway::nav
