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
#include "runtime/cycle.h"
#include "runtime/links.h"
#include "runtime/operator_lease.h"
#include "runtime/safety.h"

namespace headway::runtime {

struct BusLoopConfig {
  hal::Stance stance;  ///< the feet when the robot was set up, in the odometry frame
  nav::StepStackConfig steps;
};

/// Counted from the first cycle on.
struct BusLoopCounters {
  std::uint64_t cycles = 0;
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

  /// One cycle at `now`. While too many cycles are missed nothing more is walked.
  void cycle(Time now, CycleHealth health = CycleHealth::kOnTime) noexcept;
  /// From now on nothing more is walked, whatever is ordered.
  void come_to_rest() noexcept { resting_ = true; }
  /// Nothing is left to walk, and the control computer says that the robot stands.
  bool stands() const noexcept;

  const BusLoopCounters& counters() const noexcept { return counters_; }
  const nav::Committed& committed() const noexcept { return stack_.committed(); }
  const SafetyReport& safety() const noexcept { return safety_.report(); }

 private:
  void receive() noexcept;
  void take_samples() noexcept;
  void watch(Time now, CycleHealth health) noexcept;
  void hear_devices(Time now) noexcept;
  void hear_order() noexcept;
  SafetyInput safety_input() noexcept;
  void take_order() noexcept;
  void take_plan(const nav::StepPlan& plan) noexcept;
  void commit_steps(Time now) noexcept;
  void record_steps() noexcept;
  void open_next_session() noexcept;
  void request_walk(Time now) noexcept;
  void report(Time now) noexcept;

  hal::CanBus& bus_;
  hal::Head& head_;
  hal::Walker& walker_;
  Links& links_;
  BusObserver* observer_ = nullptr;
  nav::StepStack stack_;
  Watchdogs watchdogs_;
  OperatorLease lease_;
  Safety safety_;
  std::uint32_t stops_heard_ = 0, resets_heard_ = 0;  ///< of the operator's
  bool drives_began_ = false;                         ///< were set up once
  bool new_order_ = false;                            ///< has come in this cycle
  bool plan_waits_ = false;                           ///< that of the newest order, until it may be walked
  BusLoopCounters counters_;
  Time last_chest_{}, last_head_{};
  std::uint8_t session_ = 0;
  bool heard_ = false;                       ///< the control computer, since the beginning
  bool planned_ = false;                     ///< the session has a plan with steps
  bool resting_ = false;                     ///< for good
  std::array<StepRecord, 8> handed_over_{};  ///< step i at i modulo the size; at most four wait
  std::uint32_t recorded_ = 0;               ///< steps of the session that have begun
  nav::StackStop last_stop_ = nav::StackStop::kNone;
  hal::StepReject last_reject_ = hal::StepReject::kNone;
  std::uint32_t last_steps_ = 0;
};

}  // namespace headway::runtime
