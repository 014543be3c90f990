// The 200 Hz cycle that owns the bus: frames in, head set-points and committed steps out.
#pragma once

#include <array>
#include <cstdint>

#include "hal/can_bus.h"
#include "hal/clock.h"
#include "hal/head.h"
#include "hal/walker.h"
#include "nav/step_stack.h"
#include "runtime/bus_observer.h"
#include "runtime/links.h"

namespace headway::runtime {

struct BusLoopConfig {
  Duration period = seconds(0.005);
  hal::Stance stance;  ///< the feet when the robot was set up, in the odometry frame
  nav::StepStackConfig steps;
};

/// Counted from the first cycle on.
struct BusLoopCounters {
  std::uint64_t cycles = 0;
  std::uint64_t missed = 0;  ///< periods in which no cycle began
  std::uint64_t frames = 0;  ///< CAN frames received
  std::uint64_t plans_taken = 0, plans_late = 0, plans_refused = 0;
  std::uint64_t stops = 0;  ///< walks ended before their plan was complete
};

/// Real-time safe: cycle() neither blocks, allocates nor throws.
class BusLoop {
 public:
  BusLoop(const BusLoopConfig& config, hal::CanBus& bus, hal::Head& head, hal::Walker& walker, Links& links);

  /// What it reports is shown to `observer` too, which must outlive this.
  void show(BusObserver& observer) noexcept { observer_ = &observer; }

  /// One cycle at `now`.
  void cycle(Time now) noexcept;

  const BusLoopCounters& counters() const noexcept { return counters_; }
  const nav::Committed& committed() const noexcept { return stack_.committed(); }

 private:
  void count_cycle(Time now) noexcept;
  void receive() noexcept;
  void take_samples() noexcept;
  void take_order() noexcept;
  void take_plan(const nav::StepPlan& plan) noexcept;
  void commit_steps(Time now) noexcept;
  void record_steps() noexcept;
  void open_next_session() noexcept;
  void request_walk(Time now) noexcept;
  void report(Time now) noexcept;

  BusLoopConfig config_;
  hal::CanBus& bus_;
  hal::Head& head_;
  hal::Walker& walker_;
  Links& links_;
  BusObserver* observer_ = nullptr;
  nav::StepStack stack_;
  BusLoopCounters counters_;
  Time last_cycle_{}, last_chest_{}, last_head_{};
  std::uint8_t session_ = 0;
  bool heard_ = false;                       ///< the control computer, since the beginning
  bool planned_ = false;                     ///< the session has a plan with steps
  std::array<StepRecord, 8> handed_over_{};  ///< step i at i modulo the size; at most four wait
  std::uint32_t recorded_ = 0;               ///< steps of the session that have begun
  nav::StackStop last_stop_ = nav::StackStop::kNone;
  hal::StepReject last_reject_ = hal::StepReject::kNone;
  std::uint32_t last_steps_ = 0;
};

}  // namespace headway::runtime
