// Files that appear whole or not at all, so that a reader never meets half a map.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>

namespace headway::nav {

/// Writes FILE.part with `write` and renames it to `file`. Throws InputError when that fails, and leaves what
/// was there before.
void write_whole(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

}  // namespace headway::nav
