// What the robot may do, and what every event makes of that: the whole table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace headway::runtime {

enum class SafetyState : std::uint8_t {
  kInit,      ///< at rest or coming to it; waits until everything is there
  kReady,     ///< everything is there; no goal is pursued
  kActive,    ///< a goal is pursued: walks may begin
  kDegraded,  ///< as Active, but something is poor: a walk goes on as far as it may, none begins
  kSafeStop,  ///< comes to rest and stays there until a goal is given anew
  kFault,     ///< as SafeStop, until somebody has reset it as well
};
inline constexpr std::size_t kSafetyStates = 6;

/// In the order in which a cycle of the bus loop looks at them.
enum class SafetyEvent : std::uint8_t {
  kReset,      ///< somebody has looked at the fault
  kFault,      ///< the control computer reports a fault
  kStopAsked,  ///< by the operator, or since the program ends
  kLost,       ///< a source stays away that no walk goes without
  kBlind,      ///< nothing has been seen for so long that what comes next is another walk
  kPoor,       ///< a source is late, or has not been heard yet
  kFine,       ///< everything is there
  kIdle,       ///< no goal is pursued, or one from before the last stop
  kOrdered,    ///< a goal is pursued that was given after the last stop
};
inline constexpr std::size_t kSafetyEvents = 9;

/// The next state, by state and event.
using SafetyTable = std::array<std::array<SafetyState, kSafetyEvents>, kSafetyStates>;

namespace safety_table {
using enum SafetyState;
// clang-format off
inline constexpr SafetyTable kSafetyTable{{
  //              Reset       Fault    StopAsked   Lost        Blind       Poor        Fine        Idle        Ordered
  /* Init     */ {kInit,      kFault,  kSafeStop,  kInit,      kInit,      kInit,      kReady,     kInit,      kInit},
  /* Ready    */ {kReady,     kFault,  kSafeStop,  kInit,      kInit,      kInit,      kReady,     kReady,     kActive},
  /* Active   */ {kActive,    kFault,  kSafeStop,  kSafeStop,  kSafeStop,  kDegraded,  kActive,    kReady,     kActive},
  /* Degraded */ {kDegraded,  kFault,  kSafeStop,  kSafeStop,  kSafeStop,  kDegraded,  kActive,    kInit,      kDegraded},
  /* SafeStop */ {kSafeStop,  kFault,  kSafeStop,  kSafeStop,  kSafeStop,  kSafeStop,  kSafeStop,  kSafeStop,  kInit},
  /* Fault    */ {kSafeStop,  kFault,  kFault,     kFault,     kFault,     kFault,     kFault,     kFault,     kFault},
}};
// clang-format on
}  // namespace safety_table
using safety_table::kSafetyTable;

constexpr SafetyState next_state(const SafetyTable& table, SafetyState state, SafetyEvent event) {
  return table[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

/// Steps of a walk that is under way may be committed.
constexpr bool may_walk(SafetyState state) {
  return state == SafetyState::kActive || state == SafetyState::kDegraded;
}
/// A walk may begin from rest.
constexpr bool may_begin_to_walk(SafetyState state) { return state == SafetyState::kActive; }
/// Goals from before are void.
constexpr bool stopped(SafetyState state) {
  return state == SafetyState::kSafeStop || state == SafetyState::kFault;
}

}  // namespace headway::runtime
