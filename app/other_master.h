// Who else is on the bus: another computer that commands the robot, told by frames that only the vision
// computer sends, or another robot.
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

/// As other_master(). Throws Error where one is heard: nobody may lead the robot besides.
void refuse_other_master(hal::CanBus& bus, hal::Clock& clock);

/// Listens as long for a robot: the control computer's status, a drive's heartbeat. Throws Error where one is
/// heard: a simulated one must not mix with it.
void refuse_other_robot(hal::CanBus& bus, hal::Clock& clock);

}  // namespace headway::app
