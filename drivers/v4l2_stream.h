// An open V4L2 camera that streams: its settings, its mapped buffers, and the frames in them
// (kernel documentation: userspace-api/media/v4l/mmap).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/opened_device.h"
#include "drivers/v4l2_fault.h"
#include "drivers/v4l2_setup.h"

namespace headway::drivers {

/// A buffer that the driver has filled.
struct FilledBuffer {
  enum class StampAt : std::uint8_t { kStartOfExposure, kEndOfFrame };

  std::uint32_t index = 0;
  std::uint32_t sequence = 0;  ///< the driver's count of frames
  Duration stamp{};            ///< since the epoch of the clock that the driver uses
  StampAt stamp_at = StampAt::kEndOfFrame;
  bool is_monotonic = false;  ///< the stamp is of CLOCK_MONOTONIC
  bool is_marked = false;     ///< the driver says that the data is spoilt
  std::size_t bytes = 0;      ///< used; may be more than there are
};

/// Open, set up and streaming from construction to destruction. Neither allocates nor throws; no call waits
/// for a frame. Opening takes as long as the driver takes to talk to its device: of a USB camera some 100 ms.
class V4l2Stream {
 public:
  static constexpr std::uint32_t kBuffers = 4;
  enum class Taken : std::uint8_t { kFrame, kNothing, kFailed };

  /// None, and `fault` says why, when the camera is not there or is not as it is to be. The calls must
  /// outlive the stream.
  static std::optional<V4l2Stream> open(DeviceCalls& calls, const V4l2CameraConfig& config,
                                        V4l2Fault& fault) noexcept;

  /// The oldest filled buffer, which is the caller's until it is given back or the stream restarts.
  Taken take(FilledBuffer& into) noexcept;
  /// The data in a buffer that was taken, never beyond the buffer's end.
  std::span<const std::uint8_t> data(const FilledBuffer& buffer) const noexcept;
  /// False when the stream has failed.
  bool give_back(const FilledBuffer& buffer) noexcept;
  /// Stops, takes every buffer back and starts. False when the stream has failed.
  bool restart() noexcept;

  const V4l2Settings& settings() const noexcept { return settings_; }
  /// Why a call failed.
  const V4l2Fault& fault() const noexcept { return fault_; }

 private:
  explicit V4l2Stream(OpenedDevice device) noexcept : device_(std::move(device)) {}
  V4l2Fault map_buffers() noexcept;
  V4l2Fault start() noexcept;
  int queue(std::uint32_t index) noexcept;
  bool fail(int error) noexcept;

  OpenedDevice device_;
  std::array<MappedMemory, kBuffers>
      buffers_;  // after the device, so that they are unmapped before it closes
  V4l2Settings settings_;
  V4l2Fault fault_;
};

}  // namespace headway::drivers
