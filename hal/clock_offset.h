// How far another machine's clock is from ours, and how sure that is.
#pragma once

#include "hal/time.h"

namespace headway::hal {

/// Ours less the other's; the true difference lies within `uncertainty` of it, either way.
struct ClockOffset {
  Duration offset{}, uncertainty{};
};

}  // namespace headway::hal
