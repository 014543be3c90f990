#include "drivers/v4l2_setup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include <linux/videodev2.h>

namespace headway::drivers {

namespace {

using Step = V4l2Fault::Step;

constexpr Duration kExposureUnit = std::chrono::microseconds(100);

V4l2Fault require_camera(const OpenedDevice& device) noexcept {
  v4l2_capability capability{};
  if (const int result = device.ioctl(VIDIOC_QUERYCAP, &capability); result < 0)
    return {.step = Step::kCapability, .error = -result};
  // One driver can serve several device files; `device_caps` is this one's.
  const bool knows_own = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
  const std::uint32_t can = knows_own ? capability.device_caps : capability.capabilities;
  constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  return (can & kNeeded) == kNeeded ? V4l2Fault{} : V4l2Fault{.step = Step::kCapability};
}

V4l2Fault set_format(const OpenedDevice& device, const V4l2CameraConfig& config,
                     ImageLayout& layout) noexcept {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_pix_format& pix = format.fmt.pix;
  pix.width = static_cast<std::uint32_t>(config.width);
  pix.height = static_cast<std::uint32_t>(config.height);
  pix.pixelformat = code_of(config.format);
  pix.field = V4L2_FIELD_NONE;
  if (const int result = device.ioctl(VIDIOC_S_FMT, &format); result < 0)
    return {.step = Step::kFormat, .error = -result};
  const std::size_t row = row_bytes(config.format, config.width);
  const bool is_asked = pix.width == static_cast<std::uint32_t>(config.width) &&
                        pix.height == static_cast<std::uint32_t>(config.height) &&
                        pix.pixelformat == code_of(config.format) && pix.field == V4L2_FIELD_NONE &&
                        (row == 0 || pix.bytesperline >= row);
  if (!is_asked)
    return {.step = Step::kFormat,
            .code = pix.pixelformat,
            .width = pix.width,
            .height = pix.height,
            .field = pix.field,
            .stride = pix.bytesperline};
  layout = {config.format, config.width, config.height, row == 0 ? 0 : pix.bytesperline};
  return {};
}

std::optional<Duration> duration_of(const v4l2_fract& period) noexcept {
  if (period.numerator == 0 || period.denominator == 0) return std::nullopt;
  return seconds(static_cast<double>(period.numerator) / period.denominator);
}

V4l2Fault set_rate(const OpenedDevice& device, const V4l2CameraConfig& config,
                   std::optional<Duration>& period) noexcept {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_captureparm& capture = parameters.parm.capture;
  if (device.ioctl(VIDIOC_G_PARM, &parameters) < 0 || (capture.capability & V4L2_CAP_TIMEPERFRAME) == 0) {
    // A camera whose rate nobody can set may well have the right one: frames will tell.
    if (config.rate) period = seconds(1 / *config.rate);
    return {};
  }
  if (config.rate) {
    capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(*config.rate * 1000))};
    if (const int result = device.ioctl(VIDIOC_S_PARM, &parameters); result < 0)
      return {.step = Step::kRate, .error = -result};
  }
  period = duration_of(capture.timeperframe);
  constexpr double kTolerance = 0.02;  // 29.97 is as good as 30
  const double got = period ? 1 / to_seconds(*period) : 0;
  if (config.rate && std::abs(got - *config.rate) > kTolerance * *config.rate)
    return {.step = Step::kRate, .rate = got};
  return {};
}

/// Controls to be set in one call. Two would let the camera run with half of them, and some drivers take a
/// manual value only in the call that turns the automatic off.
class Controls {
 public:
  explicit Controls(const OpenedDevice& device) noexcept : device_(device) {}

  /// `automatic` to `off` and `id` to `value`; a camera without the automatic is fine, one without the
  /// control is not.
  V4l2Fault add(std::uint32_t automatic, std::int32_t off, std::uint32_t id, std::int64_t value) noexcept {
    if (query(automatic)) put({automatic, off, off, off, 1});
    const std::optional<v4l2_query_ext_ctrl> range = query(id);
    if (!range) return {.step = Step::kControl, .control = id, .is_missing = true};
    put({id, static_cast<std::int32_t>(value), range->minimum, range->maximum,
         static_cast<std::int64_t>(range->step)});
    return {};
  }

  V4l2Fault set() noexcept {
    if (count_ == 0) return {};
    for (std::size_t i = 0; i < count_; ++i) {
      controls_[i].id = wanted_[i].id;
      controls_[i].value = wanted_[i].value;
    }
    if (const V4l2Fault fault = call(VIDIOC_S_EXT_CTRLS)) return fault;
    if (const V4l2Fault fault = call(VIDIOC_G_EXT_CTRLS)) return fault;
    for (std::size_t i = 0; i < count_; ++i) {
      const Wanted& wanted = wanted_[i];
      const std::int64_t got = controls_[i].value;
      // Drivers round to the nearest step.
      if (2 * std::abs(got - wanted.value) > std::max<std::int64_t>(wanted.step, 1))
        return {.step = Step::kControl,
                .control = wanted.id,
                .asked = wanted.value,
                .got = got,
                .least = wanted.least,
                .most = wanted.most};
    }
    return {};
  }

  /// As read back, or as the camera has it.
  std::optional<std::int32_t> value(std::uint32_t id) const noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      if (wanted_[i].id == id) return controls_[i].value;
    }
    return std::nullopt;
  }

 private:
  struct Wanted {
    std::uint32_t id = 0;
    std::int32_t value = 0;
    std::int64_t least = 0, most = 0, step = 1;
  };

  std::optional<v4l2_query_ext_ctrl> query(std::uint32_t id) const noexcept {
    v4l2_query_ext_ctrl range{};
    range.id = id;
    if (device_.ioctl(VIDIOC_QUERY_EXT_CTRL, &range) < 0 || (range.flags & V4L2_CTRL_FLAG_DISABLED) != 0)
      return std::nullopt;
    return range;
  }

  void put(const Wanted& wanted) noexcept { wanted_[count_++] = wanted; }

  V4l2Fault call(unsigned long request) noexcept {
    v4l2_ext_controls all{};
    all.which = V4L2_CTRL_WHICH_CUR_VAL;
    all.count = static_cast<std::uint32_t>(count_);
    all.controls = controls_.data();
    const int result = device_.ioctl(request, &all);
    if (result >= 0) return {};
    const std::uint32_t id = all.error_idx < count_ ? wanted_[all.error_idx].id : 0;
    return {.step = Step::kControl, .error = -result, .control = id};
  }

  const OpenedDevice& device_;
  std::array<Wanted, 6> wanted_{};
  std::array<v4l2_ext_control, 6> controls_{};
  std::size_t count_ = 0;
};

V4l2Fault set_controls(const OpenedDevice& device, const V4l2CameraConfig& config,
                       std::optional<Duration>& exposure) noexcept {
  Controls controls(device);
  V4l2Fault fault;
  if (config.exposure)
    fault = controls.add(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, V4L2_CID_EXPOSURE_ABSOLUTE,
                         (*config.exposure + kExposureUnit / 2) / kExposureUnit);
  if (!fault && config.gain) fault = controls.add(V4L2_CID_AUTOGAIN, 0, V4L2_CID_GAIN, *config.gain);
  if (!fault && config.white_balance)
    fault = controls.add(V4L2_CID_AUTO_WHITE_BALANCE, 0, V4L2_CID_WHITE_BALANCE_TEMPERATURE,
                         *config.white_balance);
  if (!fault) fault = controls.set();
  if (const auto units = controls.value(V4L2_CID_EXPOSURE_ABSOLUTE)) exposure = *units * kExposureUnit;
  return fault;
}

}  // namespace

V4l2Fault set_up(const OpenedDevice& device, const V4l2CameraConfig& config,
                 V4l2Settings& settings) noexcept {
  settings = {};
  V4l2Fault fault = require_camera(device);
  if (!fault) fault = set_format(device, config, settings.layout);
  if (!fault) fault = set_rate(device, config, settings.period);
  if (!fault) fault = set_controls(device, config, settings.exposure);
  return fault;
}

}  // namespace headway::drivers
