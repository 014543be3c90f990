// Cameras as the frame loop sees them: the newest frame, or none. Taking never waits.
#pragma once

#include "hal/frame.h"

namespace headway::hal {

/// A pair of synchronised cameras.
class StereoCamera {
 public:
  virtual ~StereoCamera() = default;
  /// Moves the newest frame not yet taken into `into` and returns true; older ones are dropped (their
  /// sequence numbers show the gap). Returns false, and leaves `into` alone, when nothing new is there.
  virtual bool take_newest(StereoFrame& into) = 0;
};

/// A depth camera, or the simulator's range mode.
class DepthCamera {
 public:
  virtual ~DepthCamera() = default;
  /// As StereoCamera::take_newest.
  virtual bool take_newest(DepthFrame& into) = 0;
};

}  // namespace headway::hal
