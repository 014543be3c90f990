// What a fault plan does to a camera at one exposure.
#pragma once

#include <cstdint>

#include "sim_hal/fault_schedule.h"
#include "sim_hal/imager.h"
#include "sim_hal/sim_depth_camera.h"

namespace headway::sim {

struct CameraFaults {
  bool lost = false;            ///< the frame never comes
  bool frozen_picture = false;  ///< it shows what the frame before showed
  bool frozen_stamp = false;    ///< it bears the stamp of the frame before
  bool swapped = false;         ///< left and right are exchanged
  Duration late{};              ///< on its way to the computer
  double noise = 0, light = 1;  ///< [grey levels]; share of the usual light
};

/// `sequence` is the frame's number: it draws which frames are lost.
CameraFaults camera_faults(const FaultSchedule& schedule, Time exposure, std::uint64_t sequence);

/// The sensor in such noise and light.
Imager worsened(const Imager& imager, const CameraFaults& faults);

/// What a matcher makes of images in such noise. In the dark, and of exchanged images, it makes nothing that
/// the check of the cameras' sight would let pass: there all depths are missing.
DepthCameraModel worsened(const DepthCameraModel& model, const CameraFaults& faults);

}  // namespace headway::sim
