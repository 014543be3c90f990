#include "drivers/v4l2_exposure.h"

#include <cstdint>

#include <linux/videodev2.h>

#include "drivers/opened_device.h"

namespace headway::drivers {

namespace {

constexpr Duration kUnit = std::chrono::microseconds(100);

std::optional<std::int32_t> value_of(const OpenedDevice& device, std::uint32_t id) {
  v4l2_ext_control control{};
  control.id = id;
  v4l2_ext_controls all{};
  all.which = V4L2_CTRL_WHICH_CUR_VAL;
  all.count = 1;
  all.controls = &control;
  if (device.ioctl(VIDIOC_G_EXT_CTRLS, &all) < 0) return std::nullopt;
  return std::int32_t{control.value};
}

}  // namespace

std::optional<V4l2Exposure> present_exposure(DeviceCalls& calls, const char* path) {
  const int descriptor = calls.open(path);
  if (descriptor < 0) return std::nullopt;
  const OpenedDevice device(calls, descriptor);
  V4l2Exposure exposure;
  if (const auto units = value_of(device, V4L2_CID_EXPOSURE_ABSOLUTE)) exposure.time = *units * kUnit;
  const auto mode = value_of(device, V4L2_CID_EXPOSURE_AUTO);
  exposure.is_automatic = mode == V4L2_EXPOSURE_AUTO || mode == V4L2_EXPOSURE_APERTURE_PRIORITY;
  const auto priority = value_of(device, V4L2_CID_EXPOSURE_AUTO_PRIORITY);
  exposure.can_keep_rate = priority.has_value();
  exposure.may_slow_down = exposure.is_automatic && priority != 0;
  return exposure;
}

}  // namespace headway::drivers
