// Every thread that this program starts: what it does, how urgent it is. Nowhere else is one started.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "runtime/real_time.h"

namespace headway::runtime {

struct ThreadKind {
  const char* name;  ///< as the system shows it; 15 characters at most
  int priority;      ///< of SCHED_FIFO (sched(7)); 0: shares the processor like any other
  const char* does;
};

enum class ThreadId : std::uint8_t { kBus, kAdapter, kFrames, kSecond, kPictures, kRecord, kOperator };

inline constexpr std::array<ThreadKind, 7> kThreads{{
    {"headway-bus", 70, "the bus cycle: CAN in and out, head set-points, committed steps"},
    {"headway-adapter", 60, "what a CAN adapter on USB or a serial line needs: events, reopening"},
    {"headway-frames", 0, "the work between two frames: cameras, map, floor, plan"},
    {"headway-second", 0, "of the work between two frames, half of what can be divided"},
    {"headway-picture", 0, "what the simulated robot's cameras see"},
    {"headway-record", 0, "the recording and the black box: from the loops' queues to the disk"},
    {"headway-page", 0, "the operator's page: all its clients"},
}};
constexpr const ThreadKind& kind(ThreadId id) { return kThreads[static_cast<std::size_t>(id)]; }
constexpr int highest_priority() {
  int highest = 0;
  for (const ThreadKind& kind : kThreads) highest = std::max(highest, kind.priority);
  return highest;
}

/// One of them, running. What is thrown in it ends it, and is kept.
class Thread {
 public:
  /// `body` returns soon after its argument has become true. It begins when the thread is as urgent as the
  /// table says, or when that was refused. Throws InputError, and `body` never begins, where that is
  /// enforced.
  Thread(ThreadId id, std::function<void(const std::atomic<bool>& stop)> body,
         const RealTime& real_time = {});
  /// As stop().
  ~Thread();
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

  void ask_to_stop() noexcept { stop_ = true; }
  /// Asks, and waits until it has ended.
  void stop() noexcept;
  bool ended() const noexcept { return ended_; }
  /// What ended it, once ended() is true; empty when nothing went wrong.
  const std::string& failure() const { return failure_; }
  /// What the kernel refused it, and the remedy; empty when it is as urgent as the table says, or nothing was
  /// asked for.
  const std::string& refusal() const { return refusal_; }

 private:
  void say_set_up() noexcept;

  std::atomic<bool> stop_{false}, ended_{false}, set_up_{false};
  std::string failure_, refusal_;
  std::thread thread_;
};

}  // namespace headway::runtime
