// headway map convert: a map from one file format into another.
#pragma once

#include "app/commands.h"

namespace headway::app {

/// Adds `convert` below the command `map`.
void add_map_convert(CLI::App& map, Run& run);

}  // namespace headway::app
