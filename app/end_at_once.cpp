#include "app/end_at_once.h"

#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include "app/commands.h"

namespace headway::app {

void end_at_once(const std::string& error) {
  std::fflush(stdout);
  fmt::print(stderr, "headway: {}\n", error);
  std::_Exit(kInternal);
}

}  // namespace headway::app
