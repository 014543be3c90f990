// The check of an option that names a CAN bus.
#pragma once

#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "app/can_transport.h"

namespace headway::app {

inline CLI::Validator can_bus_name() {
  const auto check = [](const std::string& text) -> std::string {
    return is_can_transport(text) ? std::string()
                                  : fmt::format("is '{}', expected one like {}", text, can_transports());
  };
  return {check, "", "bus"};
}

}  // namespace headway::app
