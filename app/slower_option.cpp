#include "app/slower_option.h"

#include <fmt/format.h>

#include "app/finite_range.h"
#include "hal/error.h"

namespace headway::app {

void add_slower_option(CLI::App& command, double& slower) {
  command
      .add_option("--slower", slower,
                  "The clock runs so many times slower than real, as that of 'headway node' does: for a "
                  "simulated robot only")
      ->check(finite_in(0.1, 1000))
      ->capture_default_str();
}

void require_simulated(double slower, const std::string& bus) {
  if (slower == 1 || bus.starts_with("socketcan:vcan")) return;
  throw InputError(
      fmt::format("--slower: would stretch every time-out of a robot on {}; expected a virtual bus, such as "
                  "socketcan:vcan0",
                  bus.empty() ? "no bus" : bus));
}

}  // namespace headway::app
