// Walks that the control computer would not begin: how often in a row, and why, before the goal is given up.
// And walks amid which it began anew: at once.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "runtime/links.h"

namespace headway::runtime {

class Refusals {
 public:
  /// Gives up after `most` walks in a row that ended without a step.
  explicit Refusals(int most) : most_(most) {}

  /// Looks at the bus loop's newest report. The reason to give up, for people, when it is time to.
  std::optional<std::string> look(const BusReport& bus);
  void forget() { count_ = 0; }

 private:
  int most_;
  int count_ = 0;
  std::optional<std::uint8_t> session_;  ///< of the report before
};

}  // namespace headway::runtime
