// What one camera or two show within a few seconds: an image of each, how many came, and how they go
// together.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/report.h"
#include "drivers/stereo_pair.h"
#include "drivers/v4l2_camera.h"
#include "hal/clock.h"

namespace headway::app {

struct EyeLook {
  std::string name, path;  ///< "left", "right" or "camera"; of the device
  drivers::V4l2Settings settings;
  hal::CameraStats stats;
  double rate = 0;       ///< usable frames per second, from the first one on
  hal::GrayImage image;  ///< the newest: of a pair, or by itself where there was none. Empty: none at all
  std::string fault;     ///< what went wrong last; empty: nothing
};

struct PairLook {
  drivers::PairStats stats;
  hal::CameraState state = hal::CameraState::kStarting;
  double rate = 0;  ///< pairs exposed within the last second
  Duration tolerance{};
  /// Lower end of the histogram bin in the middle of all: right eye's exposure less the left's. None: more
  /// than the histogram's 5 ms apart.
  std::optional<Duration> exposure_gap;
};

struct CameraLook {
  std::vector<EyeLook> eyes;
  std::optional<PairLook> pair;

  /// Every camera, and the pair if there is one, has shown an image and is streaming, and most frames had a
  /// partner.
  bool is_well() const;
};

/// Looks for `time`, by a clock that sleeps, or until it is `asked` to end. Where two eyes never make a pair,
/// each is looked through by itself for another second. Throws as the cameras' constructors.
CameraLook look_through(const drivers::V4l2CameraConfig& config, Duration time, hal::Clock& clock,
                        drivers::DeviceCalls& calls);
CameraLook look_through(
    const drivers::StereoPairConfig& config, Duration time, hal::Clock& clock, drivers::DeviceCalls& calls,
    const std::function<bool()>& asked = [] { return false; });

/// Some lines for a terminal.
std::string text_of(const CameraLook& look);
/// The same, and the whole histogram.
Json json_of(const CameraLook& look);

}  // namespace headway::app
