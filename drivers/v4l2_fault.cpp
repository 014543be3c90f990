#include "drivers/v4l2_fault.h"

#include <cerrno>
#include <system_error>

#include <fmt/format.h>
#include <linux/videodev2.h>

namespace headway::drivers {

namespace {

std::string reason(int error) { return std::generic_category().message(error); }

std::string open_text(int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return "is not there; is it plugged in? 'headway camera list' shows those that are";
    case EACCES:
    case EPERM:
      return "may not be opened by this user; the group that owns it (mostly video) may";
    case EBUSY:
      return "is used by another program; end that first";
    default:
      return fmt::format("cannot be opened: {}", reason(error));
  }
}

std::string format_text(const V4l2Fault& fault, const V4l2CameraConfig& config) {
  const std::string asked =
      fmt::format("{} x {} px of {}", config.width, config.height, code_text(code_of(config.format)));
  if (fault.error != 0) return fmt::format("does not take {}: {}", asked, reason(fault.error));
  std::string got = fmt::format("{} x {} px of {}", fault.width, fault.height, code_text(fault.code));
  if (fault.field != V4L2_FIELD_NONE) got += fmt::format(", interlaced (field {})", fault.field);
  if (asked == got) got += fmt::format(" with {} bytes per line", fault.stride);
  return fmt::format("was asked for {}, and gives {}", asked, got);
}

const char* control_name(std::uint32_t id) {
  switch (id) {
    case V4L2_CID_EXPOSURE_AUTO:
      return "automatic exposure";
    case V4L2_CID_EXPOSURE_ABSOLUTE:
      return "exposure [0.1 ms]";
    case V4L2_CID_AUTOGAIN:
      return "automatic gain";
    case V4L2_CID_GAIN:
      return "gain";
    case V4L2_CID_AUTO_WHITE_BALANCE:
      return "automatic white balance";
    case V4L2_CID_WHITE_BALANCE_TEMPERATURE:
      return "white balance [K]";
    default:
      return "controls";
  }
}

std::string control_text(const V4l2Fault& fault) {
  const char* name = control_name(fault.control);
  if (fault.is_missing)
    return fmt::format("has no control for {}; leave that setting out, or take another camera", name);
  if (fault.error != 0) return fmt::format("refuses to set {}: {}", name, reason(fault.error));
  return fmt::format("was told to set {} to {}, and has {}; its range is {} to {}", name, fault.asked,
                     fault.got, fault.least, fault.most);
}

std::string start_text(int error) {
  if (error == ENOSPC)
    return "cannot start: its USB bus has no bandwidth left; use a lower rate, a smaller size or MJPEG, plug "
           "it into a port of another USB controller, or load uvcvideo with quirks=128";
  return fmt::format("cannot start: {}", reason(error));
}

std::string what_of(const V4l2Fault& fault, const V4l2CameraConfig& config) {
  using Step = V4l2Fault::Step;
  if (fault.error == EBUSY) return "is used by another program; end that first";
  switch (fault.step) {
    case Step::kNone:
      return "is well";
    case Step::kOpen:
      return open_text(fault.error);
    case Step::kCapability:
      return fault.error == 0 ? "is no camera that streams images of one plane; 'headway camera list' shows "
                                "those that do"
                              : fmt::format(
                                    "is no V4L2 device ({}); 'headway camera list' shows those "
                                    "that are",
                                    reason(fault.error));
    case Step::kFormat:
      return format_text(fault, config);
    case Step::kRate:
      return fault.error == 0
                 ? fmt::format(
                       "was asked for {:g} frames/s, and gives {:g}; another size or pixel format may "
                       "allow it",
                       config.rate.value_or(0), fault.rate)
                 : fmt::format("does not take a rate: {}", reason(fault.error));
    case Step::kControl:
      return control_text(fault);
    case Step::kBuffers:
      return fault.error == 0
                 ? "gives fewer than the buffers needed, or stamps its frames by another clock than "
                   "CLOCK_MONOTONIC"
                 : fmt::format("gives no buffers: {}", reason(fault.error));
    case Step::kStart:
      return start_text(fault.error);
    case Step::kFrames:
      return fault.error == ENODEV ? "was unplugged" : fmt::format("failed: {}", reason(fault.error));
    case Step::kSilence:
      return "sends no usable frames, though it was started anew twice";
  }
  return "";
}

}  // namespace

std::string text_of(const V4l2Fault& fault, const V4l2CameraConfig& config) {
  return fmt::format("camera {}: {}", config.path, what_of(fault, config));
}

}  // namespace headway::drivers
