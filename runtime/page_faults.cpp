#include "runtime/page_faults.h"

#include <sys/resource.h>

namespace headway::runtime {

PageFaults page_faults() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {static_cast<std::uint64_t>(usage.ru_majflt), static_cast<std::uint64_t>(usage.ru_minflt)};
}

}  // namespace headway::runtime
