// What to blame when a file cannot be written: the path that somebody gave, or the machine.
#pragma once

#include <filesystem>
#include <string>

namespace headway::config {

/// Throws Error `path: what (reason)` where the machine is at fault (a full or broken disk, too little memory
/// or too many open files), else InputError, with what to do about it. `number`: errno; 0 is not known.
[[noreturn]] void fail_to_write(const std::filesystem::path& path, const std::string& what, int number);

}  // namespace headway::config
