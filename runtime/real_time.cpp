#include "runtime/real_time.h"

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "hal/error.h"
#include "runtime/threads.h"

namespace headway::runtime {

namespace {

class KernelCalls final : public RealTimeCalls {
 public:
  int be_urgent(int priority) noexcept override {
    sched_param wanted{};
    wanted.sched_priority = priority;
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  }
  int stay_on(int processor) noexcept override {
    if (processor < 0 || processor >= CPU_SETSIZE) return EINVAL;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(processor), &one);
    return pthread_setaffinity_np(pthread_self(), sizeof one, &one);
  }
  int lock_memory() noexcept override { return mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0 : errno; }
  bool may_lock_all() noexcept override {
    rlimit limit{};
    getrlimit(RLIMIT_MEMLOCK, &limit);
    return geteuid() == 0 || limit.rlim_cur == RLIM_INFINITY;
  }
};

/// Touches what the thread's calls will use of the stack, so that no cycle is the first to.
void touch_stack() noexcept {
  constexpr std::size_t kPage = 4096;
  std::array<volatile char, 64 * kPage> stack;
  for (std::size_t i = 0; i < stack.size(); i += kPage) stack[i] = 0;
}

}  // namespace

RealTimeCalls& kernel_real_time() noexcept {
  static KernelCalls calls;
  return calls;
}

std::string real_time_remedy() {
  return fmt::format(
      "in /etc/security/limits.d/headway.conf: '@headway - rtprio {0}' and '@headway - memlock unlimited'; "
      "'sudo "
      "usermod -aG headway $USER', then log in again; in a unit: LimitRTPRIO={0} and LimitMEMLOCK=infinity",
      highest_priority());
}

std::string make_urgent(const std::string& thread, int priority, std::optional<int> processor,
                        const RealTime& real_time) {
  if (real_time.want == RealTime::Want::kOff || priority == 0) return {};
  touch_stack();
  std::string refusal;
  const int placed = processor ? real_time.calls->stay_on(*processor) : 0;
  if (placed != 0)
    refusal = fmt::format(
        "{}: processor {} refused: {}; runtime: bus_processor in the robot file: expected one of those that "
        "'nproc' counts, from 0 on",
        thread, *processor, std::strerror(placed));
  const int urgent = real_time.calls->be_urgent(priority);
  if (urgent != 0)
    refusal += fmt::format("{}{}: priority {} refused: {}; {}", refusal.empty() ? "" : "; ", thread, priority,
                           std::strerror(urgent), real_time_remedy());
  return refusal;
}

std::string lock_memory(const RealTime& real_time) {
  if (real_time.want == RealTime::Want::kOff) return {};
  std::string refusal;
  if (!real_time.calls->may_lock_all())
    refusal = "memory is not locked: its limit is not 'unlimited'; " + real_time_remedy();
  else if (const int fault = real_time.calls->lock_memory(); fault != 0)
    refusal = fmt::format("memory is not locked: {}; {}", std::strerror(fault), real_time_remedy());
  if (!refusal.empty() && real_time.want == RealTime::Want::kEnforce)
    throw InputError(refusal + "; or 'real_time: try' in the robot file");
  return refusal;
}

}  // namespace headway::runtime
