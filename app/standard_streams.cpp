#include "app/standard_streams.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "app/commands.h"
#include "hal/error.h"

namespace headway::app {

void fill_standard_streams() noexcept {
  // The kernel gives the lowest number that is free.
  int opened = 0;
  do {
    opened = ::open("/dev/null", O_RDWR);
    if (opened < 0) std::_Exit(kInternal);
  } while (opened <= STDERR_FILENO);
  ::close(opened);
}

void flush_output() {
  errno = 0;
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw Error(fmt::format("standard output cannot be written ({})",
                          errno != 0 ? std::strerror(errno) : "an earlier fault"));
}

}  // namespace headway::app
