#include "runtime/operator_line.h"

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::runtime {

void OperatorLine::go(const nav::Goal& goal) {
  const SafetyReport& now = safety();
  if (now.state == SafetyState::kFault)
    throw InputError("the control computer reports a fault; look at it, then 'headway reset'");
  for (std::size_t i = 0; i < kSources; ++i)
    if (now.sources[i].level == SourceLevel::kLost)
      throw InputError(
          fmt::format("{} lost; nothing is walked until it is back", name(static_cast<SafetySource>(i))));
  if (!links_.goals.push({goal, now.stops}))
    throw Error("the frame loop takes no goals; does it hang? See 'headway status'");
}

void OperatorLine::stay() {
  ++word_.stops;
  say();
}

void OperatorLine::reset() {
  ++word_.resets;
  say();
}

void OperatorLine::look(const LookOrder& order) {
  if (!links_.looks.push(order))
    throw Error("the frame loop takes no orders; does it hang? See 'headway status'");
}

void OperatorLine::hold(std::uint32_t number, Time now) {
  word_.lease = number;
  word_.renewed = now;
  say();
}

const SafetyReport& OperatorLine::safety() const {
  links_.safety_now.update();
  return links_.safety_now.value();
}

}  // namespace headway::runtime
