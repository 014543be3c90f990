// Sees all that the frame loop takes in, and what it makes of it; with the camera's frames and the
// stopwatch's readings that is enough to do its work again.
#pragma once

#include "hal/walker.h"
#include "runtime/frame_budget.h"
#include "runtime/links.h"

namespace headway::runtime {

/// Called in the frame loop's thread, in this order for each of its works.
class IntakeObserver {
 public:
  virtual ~IntakeObserver() = default;
  /// `level`: how much will be done with a frame.
  virtual void begins(Time now, FrameLevel level) = 0;
  virtual void takes(const hal::ChestSample& sample) = 0;
  virtual void takes(const HeadSample& sample) = 0;
  virtual void takes(const GoalOrder& order) = 0;
  virtual void takes(const LookOrder& order) = 0;
  /// `order`: null when it made none. `report`: the newest that it has taken up. `frame_waits`: a frame is at
  /// hand whose pose is not known yet.
  virtual void ends(const MotionOrder* order, const BusReport& report, bool frame_waits) = 0;
};

}  // namespace headway::runtime
