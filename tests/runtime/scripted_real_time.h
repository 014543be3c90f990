// A kernel that grants or refuses urgency as it is told, and remembers what it was asked.
#pragma once

#include <cerrno>
#include <optional>

#include "runtime/real_time.h"

namespace headway::runtime {

class ScriptedRealTime final : public RealTimeCalls {
 public:
  int be_urgent(int asked) noexcept override {
    priority = asked;
    return refuse_priority;
  }
  int stay_on(int asked) noexcept override {
    processor = asked;
    return refuse_processor;
  }
  int lock_memory() noexcept override {
    ++locks;
    return refuse_memory;
  }
  bool may_lock_all() noexcept override { return unlimited; }

  // The answers, 0 or errno:
  int refuse_priority = 0, refuse_processor = 0, refuse_memory = 0;
  bool unlimited = true;
  // What was asked last:
  std::optional<int> priority, processor;
  int locks = 0;
};

}  // namespace headway::runtime
