// The part of a robot file that a head calibration finds anew.
#pragma once

#include <string>

#include "hal/head_kinematics.h"
#include "hal/time.h"

namespace headway::app {

/// Keys of the section `neck` of a robot file, one a line, indented by two: read_robot makes the same neck of
/// them. The offset is added to the camera's stamps.
std::string neck_text(const hal::HeadKinematics& neck, Duration camera_time_offset);

}  // namespace headway::app
