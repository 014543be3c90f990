// What was wrong with a V4L2 camera, as a value that costs nothing to make, and as a sentence that says how
// to mend it.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/v4l2_config.h"

namespace headway::drivers {

struct V4l2Fault {
  enum class Step : std::uint8_t {
    kNone,
    kOpen,
    kCapability,  ///< is no camera that streams
    kFormat,      ///< size, pixel format, order of rows, bytes per line
    kRate,
    kControl,  ///< exposure, gain, white balance and their automatics
    kBuffers,
    kStart,
    kFrames,  ///< while it streamed
    kSilence  ///< neither did a restart help
  };

  Step step = Step::kNone;
  int error = 0;                        ///< errno; 0: the call went well, but answered something else
  std::uint32_t code = 0;               ///< kFormat: the pixel format that came back...
  std::uint32_t width = 0, height = 0;  ///< ...its size [px]...
  std::uint32_t field = 0;              ///< ...V4L2's code for the order of its rows...
  std::uint32_t stride = 0;             ///< ...and bytes per line
  double rate = 0;                      ///< kRate: what came back [1/s]
  std::uint32_t control = 0;            ///< kControl: V4L2's number of it; 0: unknown which
  std::int64_t asked = 0, got = 0;      ///< kControl
  std::int64_t least = 0, most = 0;     ///< kControl: the camera's range
  bool is_missing = false;              ///< kControl: the camera has no such control

  explicit operator bool() const noexcept { return step != Step::kNone; }
  /// The device is there and works, but not with the settings that it is to have.
  bool is_wrong_setting() const noexcept {
    return step == Step::kCapability || step == Step::kFormat || step == Step::kRate ||
           step == Step::kControl;
  }
};

/// One line: camera PATH: what is wrong, what was expected, how to mend it. Does not say what else the camera
/// offers: the device is needed for that.
std::string text_of(const V4l2Fault& fault, const V4l2CameraConfig& config);

}  // namespace headway::drivers
