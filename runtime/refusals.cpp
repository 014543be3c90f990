#include "runtime/refusals.h"

namespace headway::runtime {

namespace {

const char* describe(hal::StepReject reason) {
  switch (reason) {
    case hal::StepReject::kNone:
      break;
    case hal::StepReject::kSession:
      return "the step belongs to another walk";
    case hal::StepReject::kSequence:
      return "the step has not the next number";
    case hal::StepReject::kLate:
      return "the step came too late";
    case hal::StepReject::kReach:
      return "the step is beyond what it allows, in reach or in duration";
    case hal::StepReject::kFull:
      return "its queue is full";
    case hal::StepReject::kState:
      return "it is not in a state to walk";
  }
  return "no reason given";
}

/// What kept a walk from its first step; nothing when that was not the control computer's doing.
std::optional<std::string> fault_of(const BusReport& bus) {
  switch (bus.last_stop) {
    case nav::StackStop::kRejected:
      return std::string("the control computer refuses to walk: ") + describe(bus.last_reject);
    case nav::StackStop::kNoStart:
      return "the control computer takes the steps and does not begin to walk";
    case nav::StackStop::kLost:
      return "the control computer's reports stay away, or make no sense";
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<std::string> Refusals::look(const BusReport& bus) {
  const bool ended = session_ && *session_ != bus.committed.session;
  session_ = bus.committed.session;
  if (!ended) return std::nullopt;
  if (bus.last_stop == nav::StackStop::kRestarted)
    return "the control computer began anew on the way: where the robot stands in the map is not known any "
           "more";
  if (bus.last_steps > 0) count_ = 0;
  const auto fault = bus.last_steps == 0 ? fault_of(bus) : std::nullopt;
  if (!fault || ++count_ < most_) return std::nullopt;
  return *fault + " (" + std::to_string(count_) + " attempts)";
}

}  // namespace headway::runtime
