// Where the tree lies whose files tests and benchmarks read.
#pragma once

#include <filesystem>

namespace headway {

/// The top folder of the tree that this program was built from.
std::filesystem::path source_dir();

}  // namespace headway
