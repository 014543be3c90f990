// How often a thread had to wait for a page of its memory.
#pragma once

#include <cstdint>

namespace headway::runtime {

struct PageFaults {
  std::uint64_t major = 0;  ///< the page came from a disk
  std::uint64_t minor = 0;  ///< the kernel had it at hand, or made a new one
  friend PageFaults operator-(PageFaults a, PageFaults b) { return {a.major - b.major, a.minor - b.minor}; }
};

/// Of the calling thread, since it began: getrusage(2), RUSAGE_THREAD.
PageFaults page_faults() noexcept;

}  // namespace headway::runtime
