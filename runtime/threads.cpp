#include "runtime/threads.h"

#include <exception>
#include <utility>

#include <pthread.h>

#include "hal/error.h"

namespace headway::runtime {

Thread::Thread(ThreadId id, std::function<void(const std::atomic<bool>& stop)> body,
               const RealTime& real_time)
    : thread_([this, id, work = std::move(body), real_time] {
        const bool enforced = real_time.want == RealTime::Want::kEnforce;
        try {
          refusal_ = make_urgent(kind(id).name, kind(id).priority,
                                 id == ThreadId::kBus ? real_time.bus_processor : std::nullopt, real_time);
          const bool refused = !refusal_.empty() && enforced;
          say_set_up();
          if (!refused) work(stop_);
        } catch (const std::exception& fault) {
          failure_ = fault.what();
        } catch (...) {
          failure_ = "something was thrown that is no exception";
        }
        say_set_up();
        ended_ = true;
      }) {
  pthread_setname_np(thread_.native_handle(), kind(id).name);
  set_up_.wait(false);
  if (refusal_.empty() || real_time.want != RealTime::Want::kEnforce) return;
  stop();
  throw InputError(refusal_ + "; or 'real_time: try' in the robot file");
}

Thread::~Thread() { stop(); }

void Thread::say_set_up() noexcept {
  set_up_ = true;
  set_up_.notify_one();
}

void Thread::stop() noexcept {
  ask_to_stop();
  if (thread_.joinable()) thread_.join();
}

}  // namespace headway::runtime
