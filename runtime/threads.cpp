#include "runtime/threads.h"

#include <cerrno>
#include <cstring>
#include <exception>
#include <utility>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace headway::runtime {

Thread::Thread(ThreadId id, std::function<void(const std::atomic<bool>& stop)> body)
    : thread_([this, work = std::move(body)] {
        try {
          work(stop_);
        } catch (const std::exception& fault) {
          failure_ = fault.what();
        } catch (...) {
          failure_ = "something was thrown that is no exception";
        }
        ended_ = true;
      }) {
  pthread_setname_np(thread_.native_handle(), kind(id).name);
  raise_priority(kind(id));
}

Thread::~Thread() { stop(); }

void Thread::stop() noexcept {
  ask_to_stop();
  if (thread_.joinable()) thread_.join();
}

void Thread::raise_priority(const ThreadKind& kind) {
  if (kind.priority == 0) return;
  sched_param wanted{};
  wanted.sched_priority = kind.priority;
  const int fault = pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &wanted);
  if (fault != 0) refusal_ = std::string(kind.name) + ": priority refused: " + std::strerror(fault);
}

std::string lock_memory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  // With a bound, memory that is asked for later would be refused.
  if (geteuid() != 0 && limit.rlim_cur != RLIM_INFINITY)
    return "memory is not locked: memlock is not unlimited";
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return std::string("memory is not locked: ") + std::strerror(errno);
}

}  // namespace headway::runtime
