// Sees what the bus loop reports. Real-time safe: called in its cycle.
#pragma once

#include "runtime/links.h"

namespace headway::runtime {

class BusObserver {
 public:
  virtual ~BusObserver() = default;
  /// At the end of each cycle.
  virtual void reported(const BusReport& report) noexcept = 0;
  /// A step has begun.
  virtual void walked(const StepRecord& step) noexcept = 0;
};

}  // namespace headway::runtime
