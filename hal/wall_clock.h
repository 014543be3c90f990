// The time of day, for stamps that others made on it. It jumps whenever somebody sets it, so nothing else may
// rest on it.
#pragma once

#include "hal/time.h"

namespace headway::hal {

/// CLOCK_REALTIME: nanoseconds since 1970 began.
Duration wall_clock() noexcept;

}  // namespace headway::hal
