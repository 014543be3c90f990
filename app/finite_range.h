// Checks for options that are numbers. CLI11's own let "nan" pass as a number, and "-1" as an unsigned one.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <system_error>

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

/// A whole number of 64 bits, not below zero.
inline CLI::Validator seed_number() {
  const auto check = [](std::string& text) -> std::string {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size()) return {};
    return fmt::format("is {}, expected a whole number from 0 to {}", text,
                       std::numeric_limits<std::uint64_t>::max());
  };
  return {check, "", "seed"};
}

}  // namespace headway::app
