// Cameras as the frame loop sees them: the newest frame, or none, and how the camera is doing. Taking never
// waits.
#pragma once

#include <cstdint>

#include "hal/frame.h"

namespace headway::hal {

/// How a camera is doing. What is wrong stays said until a usable frame comes again.
enum class CameraState : std::uint8_t {
  kStarting,     ///< opened, and no frame has come yet
  kStreaming,    ///< usable frames come
  kSilent,       ///< no frame comes
  kFrozen,       ///< frames come, all with one stamp
  kDamaged,      ///< frames come, none of them whole
  kWrongClock,   ///< frames come with stamps of another clock, or from the future
  kWrongFormat,  ///< it came back with another format or other settings than it is to have
  kGone,         ///< unplugged or failing; it is opened again when it is back
  kUnpaired,     ///< both eyes of a pair see, but not at the same time
};

constexpr const char* text_of(CameraState state) {
  switch (state) {
    case CameraState::kStarting:
      return "starting";
    case CameraState::kStreaming:
      return "streaming";
    case CameraState::kSilent:
      return "silent";
    case CameraState::kFrozen:
      return "frozen";
    case CameraState::kDamaged:
      return "damaged frames only";
    case CameraState::kWrongClock:
      return "stamps of another clock";
    case CameraState::kWrongFormat:
      return "wrong format";
    case CameraState::kGone:
      return "gone";
    case CameraState::kUnpaired:
      return "eyes out of step";
  }
  return "unknown";
}

/// What a camera has seen since the program began. All counts only grow.
struct CameraStats {
  CameraState state = CameraState::kStarting;
  std::uint64_t usable = 0;       ///< frames that were whole and rightly stamped
  std::uint64_t lost = 0;         ///< frames that never came, told by gaps in the camera's own count
  std::uint64_t skipped = 0;      ///< usable, but not wanted: a newer one was there, or no partner
  std::uint64_t damaged = 0;      ///< marked so by the driver, cut short, or not to be decoded
  std::uint64_t frozen = 0;       ///< with the stamp of the frame before
  std::uint64_t wrong_clock = 0;  ///< with a stamp that cannot be this clock's
  std::uint64_t restarts = 0;     ///< times the stream was stopped and started
  std::uint64_t gone = 0;         ///< times the device was given up, to be opened again
};

/// A pair of synchronised cameras.
class StereoCamera {
 public:
  virtual ~StereoCamera() = default;
  /// Moves the newest frame not yet taken into `into` and returns true; older ones are dropped (their
  /// sequence numbers show the gap). Returns false, and leaves `into` alone, when nothing new is there.
  virtual bool take_newest(StereoFrame& into) = 0;
  /// As of the last call of take_newest.
  virtual CameraState state() const noexcept { return CameraState::kStreaming; }
};

/// A depth camera, or the simulator's range mode.
class DepthCamera {
 public:
  virtual ~DepthCamera() = default;
  /// As StereoCamera::take_newest.
  virtual bool take_newest(DepthFrame& into) = 0;
  /// As of the last call of take_newest.
  virtual CameraState state() const noexcept { return CameraState::kStreaming; }
};

}  // namespace headway::hal
