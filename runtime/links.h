// Everything that passes between the bus loop, the frame loop and the operator, and nothing else.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/exchange.h"
#include "hal/head.h"
#include "hal/walker.h"
#include "nav/planner.h"
#include "nav/step_stack.h"
#include "runtime/operator_lease.h"
#include "runtime/safety.h"

namespace headway::runtime {

/// Bus loop -> frame loop: the robot's state after a bus cycle.
struct BusReport {
  Time stamp{};
  hal::HeadState head;
  hal::WalkStatus walk;
  hal::WalkerHealth walker = hal::WalkerHealth::kStarting;
  std::optional<hal::ClockOffset> control_clock;  ///< nothing while it is not known
  nav::Committed committed;
  // Of the walk before this one:
  nav::StackStop last_stop = nav::StackStop::kNone;      ///< why it ended early
  hal::StepReject last_reject = hal::StepReject::kNone;  ///< what the control computer said against a step
  std::uint32_t last_steps = 0;                          ///< steps walked
  SafetyReport safety;
};

/// Frame loop -> bus loop: what the robot is to do until the next order.
struct MotionOrder {
  hal::HeadAngles look;  ///< where to point the head
  enum class Walk : std::uint8_t {
    kStop,  ///< commit nothing more: come to rest, or stay there
    kPlan,  ///< follow `plan`, in place of the last one; starts a walk when at rest
  } walk = Walk::kStop;
  nav::StepPlan plan;
  Time seen{};                   ///< when a picture that can be used was worked on last; zero: never
  bool goal = false;             ///< one is pursued, at the moment perhaps at rest
  std::uint32_t goal_after = 0;  ///< SafetyReport::stops as known when it was given
  bool end = false;              ///< a stop that holds: the program ends
};

/// Bus loop -> frame loop: one line for each step that the robot has begun to walk.
struct StepRecord {
  Time committed{};
  Duration frame_age{};  ///< age of the newest frame that the step rests upon, when it was committed
  std::uint8_t session = 0;
  hal::NumberedStep step;
  Pose2 landing;  ///< of the foot, in the odometry frame
};

/// Operator -> frame loop: a destination.
struct GoalOrder {
  nav::Goal goal;           ///< in the map
  std::uint32_t after = 0;  ///< SafetyReport::stops as the operator knew them: one from before a stop is void
};

/// Operator -> frame loop: what the head is to look at where the robot stands and pursues nothing.
struct LookOrder {
  bool around = false;   ///< in all directions, as ahead of a walk
  hal::HeadAngles head;  ///< else there
};

/// Bus loop -> whoever tells people.
struct SafetyChange {
  Time stamp{};
  SafetyReport safety;  ///< since then
};

struct HeadSample {
  Time stamp{};
  hal::HeadAngles angles;
};

/// Each with one writer and one reader.
struct Links {
  // Bus loop -> frame loop
  hal::NewestSlot<BusReport> report;
  hal::BoundedQueue<hal::ChestSample, 256> chest;
  hal::BoundedQueue<HeadSample, 256> head;
  // Frame loop -> bus loop
  hal::NewestSlot<MotionOrder> order;
  // Operator -> bus loop, frame loop
  hal::NewestSlot<OperatorWord> operator_word;
  hal::BoundedQueue<GoalOrder, 8> goals;
  hal::BoundedQueue<LookOrder, 8> looks;
  // Bus loop -> whoever tells people; where nobody listens, what does not fit is dropped
  hal::NewestSlot<SafetyReport> safety_now;
  hal::BoundedQueue<SafetyChange, 64> safety;
  hal::BoundedQueue<StepRecord, 256> steps;
};

}  // namespace headway::runtime
