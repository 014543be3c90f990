// Files that outlive the program's death and the machine's: whoever looks finds the old state or the new one,
// whole. It stands in this room because vision and nav hold no descriptors, and a write is only safe on one.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>

namespace headway::runtime {

/// Writes FILE.part with `write`, waits until the disk has it, and renames it to `file`. Once this returns,
/// the new state stays through kill -9 and power loss; before, the old one does. One writer at a time. Throws
/// when it cannot be done, and leaves what was there: InputError where the path is wrong (no such folder, or
/// a folder itself), Error where the machine does not let it be written or has no room for it.
void write_durably(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

}  // namespace headway::runtime
