// How one V4L2 camera is to be set.
#pragma once

#include <optional>
#include <string>

#include "drivers/back_off.h"
#include "drivers/pixel_format.h"
#include "hal/time.h"

namespace headway::drivers {

struct V4l2CameraConfig {
  /// Best one of /dev/v4l/by-path: the port says which eye it is; two equal cameras often have no serial.
  std::string path;
  int width = 640, height = 480;  ///< [px]
  PixelFormat format = PixelFormat::kYuyv;
  std::optional<double> rate;         ///< frames per second; none: what the camera gives by itself
  std::optional<Duration> exposure;   ///< to 0.1 ms; none: the camera's automatic, if it has one
  std::optional<int> gain;            ///< in the camera's own units; none: as for exposure
  std::optional<int> white_balance;   ///< colour temperature [K]; none: as for exposure
  Duration readout{};                 ///< from the exposure's end to the frame's, where drivers stamp that
  int y16_bits = 16;                  ///< significant bits of Y16's values, 8..16
  double metres_per_count = 0.001;    ///< of Z16's values
  Duration first_frame = seconds(2);  ///< patience after the stream was started
  BackOffConfig retry{};              ///< of opening it again

  /// Throws InputError when no camera could be set so.
  void validate() const;
};

}  // namespace headway::drivers
