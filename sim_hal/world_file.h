// Worlds as YAML files (config/worlds).
#pragma once

#include <filesystem>

#include "config/yaml_reader.h"
#include "sim_hal/world.h"

namespace headway::sim {

/// Reads a whole world. Throws InputError `file:line: key: what, expected what`.
World read_world(const std::filesystem::path& file);

/// The same from an open mapping; calls finish() on it.
World world_from(const config::Section& section);

}  // namespace headway::sim
