#include "app/end_at_once.h"

#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/standard_streams.h"

namespace headway::app {

void end_at_once(const std::string& error) {
  std::fflush(stdout);
  say_error("headway: {}\n", error);
  std::_Exit(kInternal);
}

}  // namespace headway::app
