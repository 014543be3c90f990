// What was done with the frames, as a report tells it.
#pragma once

#include "app/report.h"
#include "runtime/frame_loop.h"

namespace headway::app {

/// How many frames were used, and at which level; how many were not, and why.
Json frames_json(const runtime::FrameLoopCounters& frames);

}  // namespace headway::app
