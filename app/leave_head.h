// The orderly end of who has led the head's drives.
#pragma once

#include "drivers/cia402_head.h"
#include "hal/can_bus.h"
#include "hal/clock.h"

namespace headway::app {

/// Lets the drives stop and hold, and no longer wait for our heartbeat; else they would miss it and send an
/// emergency. Takes a second at most: a drive that is not reached by then is stopped by its own time-out.
/// By a clock that sleeps; nobody else ticks the head.
void leave_head(drivers::Cia402Head& head, hal::CanBus& bus, hal::Clock& clock) noexcept;

}  // namespace headway::app
