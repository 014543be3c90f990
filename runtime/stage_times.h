// Time spent on each stage of one frame.
#pragma once

#include "hal/time.h"

namespace headway::runtime {

struct StageTimes {
  Duration see{}, map{}, floor{}, plan{};  ///< map: aligned with it and taken in
  Duration total() const { return see + map + floor + plan; }
};

}  // namespace headway::runtime
