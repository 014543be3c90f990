// How a camera exposes at this moment, for tools (kernel documentation:
// userspace-api/media/v4l/ext-ctrls-camera).
#pragma once

#include <optional>

#include "drivers/device_calls.h"
#include "hal/time.h"

namespace headway::drivers {

struct V4l2Exposure {
  std::optional<Duration> time;  ///< none: the camera does not say
  bool is_automatic = false;
  /// It is automatic, and nothing keeps the camera from exposing longer than a frame's period.
  bool may_slow_down = false;
  bool can_keep_rate = false;  ///< it has the control that would (V4L2_CID_EXPOSURE_AUTO_PRIORITY)
};

/// Of the camera at `path`, which may be in use. Nothing when it cannot be opened.
std::optional<V4l2Exposure> present_exposure(DeviceCalls& calls, const char* path);

}  // namespace headway::drivers
