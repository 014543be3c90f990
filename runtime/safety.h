// The state that the robot is in for safety's sake, kept by the bus loop: what the table makes of each
// cycle's events, and why.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "runtime/safety_table.h"
#include "runtime/watchdogs.h"

namespace headway::runtime {

/// What a cycle knows, besides the watchdogs.
struct SafetyInput {
  bool reset = false;            ///< asked for since the last cycle
  bool fault = false;            ///< the control computer reports one
  bool stop_asked = false;       ///< by the operator since the last cycle
  bool ends = false;             ///< the program does, and nothing more is walked
  bool goal = false;             ///< one is pursued
  std::uint32_t goal_after = 0;  ///< it was given by somebody who knew of so many stops (SafetyReport::stops)
};

/// The safety state, and what it came from.
struct SafetyReport {
  struct Watch {
    SourceLevel level = SourceLevel::kUnused;
    std::uint32_t poor = 0, lost = 0;  ///< times
  };
  SafetyState state = SafetyState::kInit;
  SafetyEvent event = SafetyEvent::kPoor;  ///< that led to the state
  std::optional<SafetySource> source;      ///< that was missing then, where it was one
  std::uint32_t stops = 0;                 ///< goals from before the newest of so many stops are void
  std::array<Watch, kSources> sources{};   ///< by SafetySource

  const Watch& of(SafetySource s) const noexcept { return sources[static_cast<std::size_t>(s)]; }
};

const char* name(SafetyState state);
const char* name(SafetyEvent event);
/// Why it is in that state, for people: "control computer lost"; while it waits, for what.
std::string describe(const SafetyReport& report);

/// No clock, no heap, no exceptions; a plain value. After a stop no walk begins unless a goal is given by
/// somebody who knew of that stop, at a moment when nothing of what stops a walk is missing.
class Safety {
 public:
  explicit Safety(const SafetyTable& table = kSafetyTable, SafetyState begin = SafetyState::kInit) noexcept
      : table_(table) {
    report_.state = begin;
  }

  /// One cycle, after the watchdogs have looked.
  void cycle(const SafetyInput& input, const Watchdogs& watchdogs) noexcept;

  SafetyState state() const noexcept { return report_.state; }
  const SafetyReport& report() const noexcept { return report_; }

 private:
  void take(SafetyEvent event, std::optional<SafetySource> source = std::nullopt) noexcept;

  SafetyTable table_;
  SafetyReport report_;
};

}  // namespace headway::runtime
