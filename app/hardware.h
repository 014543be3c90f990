// What `headway run` opens: the robot's bus and its cameras.
#pragma once

#include <filesystem>
#include <memory>

#include "app/robot_file.h"
#include "hal/camera.h"
#include "hal/clock.h"

namespace headway::app {

/// Throws InputError that names what is missing, the key in `robot_file` and the option.
void require_complete(const HardwareConfig& hardware, const std::filesystem::path& robot_file);

/// The pair as the rig knows it. Throws InputError for what a user can mend.
std::unique_ptr<hal::StereoCamera> open_cameras(const HardwareConfig& hardware, const vision::StereoRig& rig,
                                                const hal::Clock& clock);

}  // namespace headway::app
