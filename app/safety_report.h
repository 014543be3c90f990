// The safety state as a report tells it.
#pragma once

#include "app/report.h"
#include "runtime/safety.h"

namespace headway::app {

/// The state, why, how many stops there were, and how often each source was poor and lost.
Json safety_json(const runtime::SafetyReport& safety);

}  // namespace headway::app
