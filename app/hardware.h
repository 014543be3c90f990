// What `headway run` opens: the robot's bus and its cameras.
#pragma once

#include <memory>

#include "app/robot_file.h"
#include "drivers/stereo_pair.h"
#include "hal/camera.h"
#include "hal/clock.h"

namespace headway::app {

/// Throws InputError `file:line: key: what` that names what is missing, and the option that gives it too.
void require_complete(const HardwareConfig& hardware);

/// How the cameras are to be set, for the rig that they are.
drivers::StereoPairConfig camera_pair(const HardwareConfig& hardware, const vision::StereoRig& rig);

/// The pair as the rig knows it. Throws InputError for what a user can mend.
std::unique_ptr<hal::StereoCamera> open_cameras(const HardwareConfig& hardware, const vision::StereoRig& rig,
                                                const hal::Clock& clock);

}  // namespace headway::app
