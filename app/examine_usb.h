// The doctor's look at what hangs on the USB: whether its buses carry what the cameras send, and what cameras
// and adapter call themselves.
#pragma once

#include <filesystem>
#include <string>

#include "app/doctor.h"
#include "drivers/stereo_pair.h"

namespace headway::app {

/// What two cameras, set so, send [bytes/s], against what each bus and each port carries. `root` holds sys
/// and dev: "/", or a test's.
void examine_usb_cameras(const std::filesystem::path& root, const drivers::StereoPairConfig& cameras,
                         Diagnosis& into);

/// The adapter behind an interface of the kernel, such as can0. Nothing is said of one that is not on the
/// USB.
void examine_usb_adapter(const std::filesystem::path& root, const std::string& interface, Diagnosis& into);

}  // namespace headway::app
