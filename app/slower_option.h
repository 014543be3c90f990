// --slower, of the commands that lead a simulated robot which its machine is too slow for.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace headway::app {

void add_slower_option(CLI::App& command, double& slower);

/// Throws InputError where a clock that is not the real one would lead a robot on a bus that may be real.
void require_simulated(double slower, const std::string& bus);

}  // namespace headway::app
