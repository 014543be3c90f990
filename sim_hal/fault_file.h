// Fault plans as YAML files (config/faults).
#pragma once

#include <filesystem>

#include "config/yaml_reader.h"
#include "sim_hal/faults.h"

namespace headway::sim {

/// Reads a whole plan. Throws InputError `file:line: key: what, expected what`.
FaultPlan read_faults(const std::filesystem::path& file);

/// The same from an open mapping; calls finish() on it.
FaultPlan faults_from(const config::Section& section);

}  // namespace headway::sim
