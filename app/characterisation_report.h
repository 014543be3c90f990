// What characterise finds, in numbers.
#pragma once

#include "app/characterisation.h"
#include "app/report.h"

namespace headway::app {

/// The frame of what it holds and of the meshes.
inline constexpr const char* kCharacterisedFrame =
    "rectified left camera, optical: x right, y down, z forward; metres";

Json characterisation_report(const Characterisation& characterisation);

}  // namespace headway::app
