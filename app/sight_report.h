// What a report says of how the cameras see.
#pragma once

#include "app/report.h"
#include "vision/sight_check.h"

namespace headway::app {

/// The numbers behind a judgement, and what was found wrong: `findings` is empty for a healthy pair.
Json sight_report(const vision::SightReport& sight);

}  // namespace headway::app
