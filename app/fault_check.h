// What the program was seen to do about the faults of a simulated run, and how soon.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/report.h"
#include "drivers/can_walker.h"
#include "hal/can_bus.h"
#include "runtime/bus_loop.h"
#include "runtime/frame_loop.h"
#include "sim_hal/fault_schedule.h"

namespace headway::app {

/// What the program shows of itself after a cycle of the bus.
struct ProgramSigns {
  runtime::FrameLoopCounters frames;
  std::uint64_t cycles_missed = 0;
  drivers::WalkerCounts unused;  ///< frames of the control computer
  hal::HeadHealth head = hal::HeadHealth::kStarting;
  hal::WalkerHealth control = hal::WalkerHealth::kStarting;
  hal::StepReject reject = hal::StepReject::kNone;
  bool clock_known = false;  ///< the control computer's
  hal::CanBusState bus = hal::CanBusState::kErrorActive;
  nav::Committed committed;
  bool braking = false;        ///< the control computer takes no more steps, whoever asked for that
  Duration phase_remaining{};  ///< until the step under way, with the shift of weight before the first, ends
};

/// By when a fault must have been answered, and how.
struct Demand {
  enum class Answer : std::uint8_t {
    kStop,     ///< no more steps are committed
    kDegrade,  ///< the head is not called ready any more
  } answer = Answer::kStop;
  Duration within{};  ///< after it begins, it is answered
  /// After it begins, no step is committed any more while it lasts. Nothing: a walk may be tried again.
  std::optional<Duration> last_step{};
};

struct DemandConfig {
  nav::StepStackConfig steps;
  Duration step = seconds(0.8);  ///< the longest
};

/// Nothing for a fault that a walking robot need not answer: too short, too weak, or harmless. The step under
/// way as it begins ends after `remaining`: until then, the next step need not be there.
std::optional<Demand> demand_of(const sim::Fault& fault, Duration remaining, const DemandConfig& config);

class FaultCheck {
 public:
  struct Sign {
    Time at{};
    std::string what;
  };
  struct Row {
    sim::Fault fault;
    std::optional<Time> begun, ended;   ///< nothing: the run was over
    bool walking = false;               ///< as it began: the robot was under way, and more steps might follow
    std::optional<Sign> noticed;        ///< the first count or state that tells of such faults
    std::optional<Demand> demand;       ///< nothing: none needed
    std::optional<Sign> answered;       ///< as demanded
    std::optional<Duration> last_step;  ///< as Demand's; a robot that stood must not set off later either
    int late_steps = 0;                 ///< committed while it was on, and later than demanded
  };

  FaultCheck(const sim::FaultPlan& plan, const DemandConfig& config);

  /// After each cycle of the bus.
  void look(Time now, const sim::FaultSchedule& schedule, const ProgramSigns& signs);

  const std::vector<Row>& rows() const { return rows_; }
  Json report() const;

 private:
  void begin(Row& row, Time at);
  void watch(Row& row, Time now, const ProgramSigns& signs);

  DemandConfig config_;
  std::vector<Row> rows_;
  ProgramSigns last_;
};

/// One line for each fault, for people.
std::string fault_lines(const FaultCheck& check);

/// The time from a row's beginning to a sign [s].
double after(const FaultCheck::Row& row, const FaultCheck::Sign& sign);
/// Its demand was not met, or later than it should have been.
bool is_late(const FaultCheck::Row& row);

}  // namespace headway::app
