// Times of processor use rather than of the clock on the wall: on a busy machine they are what can be
// compared.
#pragma once

#include <algorithm>
#include <limits>

#include <time.h>

namespace headway::bench {

/// What this thread has used of its processor so far [s].
inline double cpu_seconds() {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

/// The least that one call of `work` took [s]. Take turns between works whose ratio matters: a machine that
/// is slow for a while is then slow for all of them.
class LeastTime {
 public:
  template <class Work>
  void take(Work&& work) {
    const double before = cpu_seconds();
    work();
    seconds_ = std::min(seconds_, cpu_seconds() - before);
  }
  double seconds() const { return seconds_; }

 private:
  double seconds_ = std::numeric_limits<double>::infinity();
};

}  // namespace headway::bench
