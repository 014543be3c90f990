// The part of a robot file that a head calibration finds anew.
#pragma once

#include <string>

#include "hal/head_kinematics.h"

namespace headway::app {

/// Keys of the section `neck` of a robot file, one a line, indented by two: read_robot makes the same neck of
/// them.
std::string neck_text(const hal::HeadKinematics& neck);

}  // namespace headway::app
