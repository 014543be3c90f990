// A check for options that are numbers: finite, and within bounds. CLI::Range lets "nan" pass.
#pragma once

#include <cmath>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace headway::app {

/// Each value must lie in [lowest, highest].
inline CLI::Validator finite_in(double lowest, double highest) {
  const auto check = [lowest, highest](std::string& text) -> std::string {
    double value = 0;
    const bool number = CLI::detail::lexical_cast(text, value);
    if (number && std::isfinite(value) && value >= lowest && value <= highest) return {};
    return fmt::format("is {}, expected a number from {} to {}", text, lowest, highest);
  };
  return {check, fmt::format("in [{} - {}]", lowest, highest), "finite"};
}

}  // namespace headway::app
