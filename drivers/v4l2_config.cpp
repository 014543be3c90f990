#include "drivers/v4l2_config.h"

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::drivers {

void V4l2CameraConfig::validate() const {
  const auto require = [&](bool fulfilled, const char* what) {
    if (!fulfilled) throw InputError(fmt::format("camera {}: {}", path, what));
  };
  require(!path.empty(), "path is empty, expected a device such as one of /dev/v4l/by-path");
  require(width > 0 && width <= 16384 && height > 0 && height <= 16384, "size, expected 1..16384 px");
  require(!rate || (*rate >= 0.1 && *rate <= 1000), "rate, expected 0.1..1000 frames/s");
  require(!exposure || (*exposure >= seconds(1e-4) && *exposure <= seconds(10)),
          "exposure, expected 0.1 ms to 10 s");
  require(!rate || !exposure || to_seconds(*exposure) * *rate <= 1,
          "exposure, expected no longer than the time from frame to frame");
  require(!gain || *gain >= 0, "gain, expected 0 or more");
  require(!white_balance || *white_balance > 0, "white balance, expected a colour temperature in kelvin");
  require(readout >= Duration::zero() && readout <= seconds(1), "readout, expected 0..1 s");
  require(y16_bits >= 8 && y16_bits <= 16, "significant bits of Y16, expected 8..16");
  require(metres_per_count > 0 && metres_per_count <= 1, "metres per count, expected more than 0, up to 1");
  require(first_frame > Duration::zero() && first_frame <= seconds(60), "first frame, expected up to 60 s");
  require(retry.is_sound(), "retry, expected 1 ms to an hour, and the longest no shorter than the first");
}

}  // namespace headway::drivers
