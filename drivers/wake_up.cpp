#include "drivers/wake_up.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

#include <sys/eventfd.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::drivers {

WakeUp::WakeUp() : descriptor_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (descriptor_ < 0) {
    throw Error(std::string("eventfd: ") + std::strerror(errno) +
                ", expected a descriptor; raise the limit of open files (ulimit -n)");
  }
}

WakeUp::~WakeUp() { close(descriptor_); }

void WakeUp::ring() noexcept {
  // Fails only when the bell has rung 2^64 times unheard: then it rings already.
  const std::uint64_t once = 1;
  [[maybe_unused]] const auto written = write(descriptor_, &once, sizeof once);
}

void WakeUp::hear() noexcept {
  std::uint64_t times = 0;
  [[maybe_unused]] const auto got = read(descriptor_, &times, sizeof times);
}

}  // namespace headway::drivers
