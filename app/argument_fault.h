// What is wrong with the program's arguments, for a person: where, what, and what was expected.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace headway::app {

/// One line, which ends with where to read on. `program` has thrown `fault` while it parsed.
std::string argument_fault(const CLI::App& program, const CLI::ParseError& fault);

}  // namespace headway::app
