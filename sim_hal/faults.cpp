#include "sim_hal/faults.h"

#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::sim {

namespace {

using enum FaultKind;

constexpr std::array<FaultTraits, 25> kKinds{{
    {kFrameLoss, "frame_loss", {.share = true}},
    {kFrameDelay, "frame_delay", {.delay = true}},
    {kFrozenPicture, "frozen_picture", {}},
    {kFrozenStamp, "frozen_stamp", {}},
    {kNoise, "noise", {.noise = true}},
    {kDark, "dark", {.light = true}},
    {kSwapped, "swapped", {}},
    {kCanLoss, "can_loss", {.share = true, .id = true}},
    {kCanDelay, "can_delay", {.share = true, .id = true, .delay = true}},
    {kCanCorruption, "can_corruption", {.share = true, .id = true}},
    {kBusOff, "bus_off", {}},
    {kStallPan, "stall_pan", {}},
    {kStallTilt, "stall_tilt", {}},
    {kRebootPan, "reboot_pan", {.length = false}},
    {kRebootTilt, "reboot_tilt", {.length = false}},
    {kSilentPan, "silent_pan", {}},
    {kSilentTilt, "silent_tilt", {}},
    {kSilentControl, "silent_control", {}},
    {kSlowControl, "slow_control", {.delay = true}},
    {kRejectingControl, "rejecting_control", {}},
    {kRestartControl, "restart_control", {}},
    {kControlClockJump, "control_clock_jump", {.jump = true, .length = false}},
    {kStarvedBusLoop, "starved_bus_loop", {}},
    {kStarvedFrameLoop, "starved_frame_loop", {}},
    {kStarvedLoops, "starved_loops", {}},
}};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kKinds.size(); ++i)
    if (static_cast<std::size_t>(kKinds[i].kind) != i) return false;
  return static_cast<std::size_t>(kStarvedLoops) + 1 == kKinds.size();
}
static_assert(in_order());

}  // namespace

std::span<const FaultTraits> fault_kinds() { return kKinds; }

const FaultTraits& traits(FaultKind kind) { return kKinds.at(static_cast<std::size_t>(kind)); }

void validate(const FaultPlan& plan) {
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Fault& fault = plan[i];
    const auto require = [&](bool holds, const char* key, double value, const char* expected) {
      if (!holds)
        throw InputError(fmt::format("faults: number {} ({}): {}: {}, expected {}", i,
                                     traits(fault.kind).name, key, value, expected));
    };
    require(fault.begin >= Duration{}, "begin", to_seconds(fault.begin), "at least 0 s");
    require(fault.length >= Duration{}, "length", to_seconds(fault.length), "at least 0 s");
    require(fault.share >= 0 && fault.share <= 1, "share", fault.share, "0 to 1");
    require(fault.delay >= Duration{}, "delay", to_seconds(fault.delay), "at least 0 s");
    require(fault.noise >= 0 && std::isfinite(fault.noise), "noise", fault.noise, "at least 0 grey levels");
    require(fault.light >= 0 && fault.light <= 1, "light", fault.light, "0 to 1");
  }
}

}  // namespace headway::sim
