// Things that go wrong at a given time, so that a run with faults is as repeatable as one without.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "hal/time.h"

namespace headway::sim {

enum class FaultKind : std::uint8_t {
  // The cameras.
  kFrameLoss,   ///< `share` of the frames never come
  kFrameDelay,  ///< frames come `delay` late, with the stamp of their exposure, and hold up those behind them
  kFrozenPicture,  ///< frames come with new stamps and numbers, and show the same picture again and again
  kFrozenStamp,    ///< frames come, all with the stamp of the last one before
  kNoise,          ///< `noise` of each pixel, beside the usual
  kDark,           ///< no more than `light` of the usual light
  kSwapped,        ///< left and right are exchanged
  // The CAN bus, for frames with the identifier `id`.
  kCanLoss,        ///< `share` of the frames vanish
  kCanDelay,       ///< `share` of the frames come `delay` late
  kCanCorruption,  ///< `share` of the frames have a bit turned over, as a faulty gateway would
  kBusOff,         ///< the vision computer is off the bus
  // The head's drives.
  kStallPan,  ///< the joint is stuck
  kStallTilt,
  kRebootPan,  ///< at `begin`, once
  kRebootTilt,
  kSilentPan,  ///< the drive neither hears nor speaks
  kSilentTilt,
  // The control computer.
  kSilentControl,     ///< neither hears nor speaks (it walks on as it would without its master)
  kSlowControl,       ///< all that it hears and says is `delay` late
  kRejectingControl,  ///< refuses every step
  kRestartControl,    ///< its program ends at `begin` and begins anew after `length`
  kControlClockJump,  ///< at `begin`, once, its clock is put forward by `jump`
  // The vision computer itself: processor time goes elsewhere.
  kStarvedBusLoop,    ///< the bus loop does not run
  kStarvedFrameLoop,  ///< the frame loop does not run
  kStarvedLoops,      ///< neither does
};

/// From when a fault's time counts.
enum class FaultClock : std::uint8_t { kPowerOn, kFirstStep };

constexpr std::uint32_t kAnyId = 0xffffffff;

struct Fault {
  FaultKind kind = FaultKind::kFrameLoss;
  FaultClock after = FaultClock::kPowerOn;
  Duration begin{}, length{};
  double share = 1;           ///< of the frames, drawn by the seed
  std::uint32_t id = kAnyId;  ///< of CAN frames; kAnyId: all
  Duration delay{};
  double noise = 0;  ///< standard deviation [grey levels]
  double light = 1;  ///< share of the usual light
  Duration jump{};   ///< back, when negative
};

using FaultPlan = std::vector<Fault>;

/// What a kind reads of a Fault, beside its times.
struct FaultParameters {
  bool share = false, id = false, delay = false, noise = false, light = false, jump = false;
  bool length = true;
};

struct FaultTraits {
  FaultKind kind;
  std::string_view name;  ///< in files and reports
  FaultParameters uses;
};

/// One entry for each kind, in the order of the enumeration.
std::span<const FaultTraits> fault_kinds();
const FaultTraits& traits(FaultKind kind);

/// Throws InputError "faults: number I (name): key: what, expected what" when a plan cannot be.
void validate(const FaultPlan& plan);

}  // namespace headway::sim
