// A depth camera that sends Z16 frames over V4L2.
#pragma once

#include "drivers/v4l2_camera.h"
#include "hal/camera.h"

namespace headway::drivers {

/// As V4l2Camera: no thread, no call waits.
class V4l2DepthCamera final : public hal::DepthCamera {
 public:
  /// As V4l2Camera's, with the format Z16 whatever the configuration says.
  V4l2DepthCamera(V4l2CameraConfig config, const hal::Clock& clock, DeviceCalls& calls = kernel_calls());

  bool take_newest(hal::DepthFrame& into) override;
  hal::CameraState state() const noexcept override { return camera_.stats().state; }

  const V4l2Camera& camera() const noexcept { return camera_; }

 private:
  V4l2Camera camera_;
};

}  // namespace headway::drivers
