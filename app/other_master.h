// Whether another computer commands the robot: frames on the bus that only the vision computer sends.
#pragma once

#include <optional>
#include <string>

#include "hal/can_bus.h"
#include "hal/clock.h"

namespace headway::app {

/// What such a frame is, by its identifier (docs/bus.md); nothing for all others.
std::optional<std::string> word_of_a_master(const hal::CanFrame& frame);

/// How long a master is silent at most: its heartbeat comes every 100 ms, SYNC every 20 ms.
inline constexpr Duration kMasterIsHeardWithin = std::chrono::milliseconds(500);

/// Listens for so long, by a clock that sleeps, sends nothing, and ends with the first such frame.
std::optional<std::string> other_master(hal::CanBus& bus, hal::Clock& clock,
                                        Duration time = kMasterIsHeardWithin);

}  // namespace headway::app
