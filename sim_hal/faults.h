// Things that go wrong at a given time, so that a run with faults is as repeatable as one without.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/time.h"

namespace headway::sim {

enum class FaultKind : std::uint8_t {
  kDropFrames,     ///< frames with the identifier vanish
  kDelayFrames,    ///< frames with the identifier come `delay` late
  kCorruptFrames,  ///< frames with the identifier have a bit turned over
  kBusOff,         ///< the vision computer is off the bus
  kStallPan,       ///< the joint is stuck
  kStallTilt,
  kRebootPan,  ///< at `begin`, once
  kRebootTilt,
  kSilentPan,  ///< the drive neither hears nor speaks
  kSilentTilt,
  kSilentControl,  ///< the control computer neither hears nor speaks (it walks on as it would without its
                   ///< master)
};

struct Fault {
  FaultKind kind = FaultKind::kDropFrames;
  Duration begin{}, length{};  ///< after the robot was switched on
  std::uint32_t id = 0;        ///< of frame faults; kAnyId: all
  Duration delay{};
};
constexpr std::uint32_t kAnyId = 0xffffffff;

using FaultPlan = std::vector<Fault>;

}  // namespace headway::sim
