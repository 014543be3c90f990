#include "drivers/v4l2_depth_camera.h"

namespace headway::drivers {

namespace {

V4l2CameraConfig as_depth(V4l2CameraConfig config) {
  config.format = PixelFormat::kZ16;
  return config;
}

}  // namespace

V4l2DepthCamera::V4l2DepthCamera(V4l2CameraConfig config, const hal::Clock& clock, DeviceCalls& calls)
    : camera_(as_depth(std::move(config)), clock, calls) {}

bool V4l2DepthCamera::take_newest(hal::DepthFrame& into) {
  camera_.poll();
  while (camera_.waiting().size() > 1) camera_.skip();
  if (camera_.waiting().empty()) return false;
  const V4l2Camera::Waiting newest = camera_.waiting().front();
  // Its buffer was checked to hold a whole frame, so the copy cannot fail.
  if (!camera_.take(into)) return false;
  into.exposure = newest.exposure;
  into.sequence = newest.sequence;
  return true;
}

}  // namespace headway::drivers
