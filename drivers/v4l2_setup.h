// Settings of an open V4L2 camera: asked for, read back, and refused when they are others
// (kernel documentation: userspace-api/media/v4l, VIDIOC_QUERYCAP, S_FMT, S_PARM, S_EXT_CTRLS).
#pragma once

#include <optional>

#include "drivers/opened_device.h"
#include "drivers/v4l2_config.h"
#include "drivers/v4l2_fault.h"

namespace headway::drivers {

/// What a camera was set to.
struct V4l2Settings {
  ImageLayout layout;
  std::optional<Duration> period;    ///< from frame to frame; none: the driver does not say
  std::optional<Duration> exposure;  ///< as the camera has it; none: automatic, or it does not say
};

/// All settings, in the order that drivers want. Neither allocates nor throws.
V4l2Fault set_up(const OpenedDevice& device, const V4l2CameraConfig& config, V4l2Settings& settings) noexcept;

}  // namespace headway::drivers
