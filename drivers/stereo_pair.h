// Two V4L2 cameras as one stereo camera: frames of both eyes that were exposed at the same moment.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/v4l2_camera.h"
#include "hal/camera.h"

namespace headway::drivers {

struct StereoPairConfig {
  V4l2CameraConfig left, right;
  /// Between the exposures of a pair at most; none: a quarter of the period, and no more than 5 ms.
  std::optional<Duration> tolerance;

  /// Throws InputError as V4l2CameraConfig::validate, and where the eyes are one device, or would differ in
  /// size, rate, exposure, gain or white balance.
  void validate() const;
};

/// What a pair has seen since the program began. All counts only grow.
struct PairStats {
  /// Of `differences`: the middle ones are 0.5 ms wide and reach from -5 to 5 ms, the outer two hold the
  /// rest.
  static constexpr std::size_t kBins = 22;
  static constexpr Duration kBinWidth = std::chrono::microseconds(500);

  std::uint64_t pairs = 0;     ///< pairs seen, taken or not
  std::uint64_t unpaired = 0;  ///< frames of either eye for which the other had none near enough
  /// Right eye's exposure less the left's: of pairs, and of unpaired frames to the nearest there was.
  std::array<std::uint64_t, kBins> differences{};
};

/// Has no thread, and no call waits; see V4l2Camera. Of MJPEG frames only those of the pair that is handed
/// out are decoded.
class StereoPair final : public hal::StereoCamera {
 public:
  /// Throws InputError as StereoPairConfig::validate, else as V4l2Camera's. Clock and calls must outlive it.
  StereoPair(const StereoPairConfig& config, const hal::Clock& clock, DeviceCalls& calls = kernel_calls());

  /// The sequence is the left eye's, the exposure the middle of both.
  bool take_newest(hal::StereoFrame& into) override;
  /// The eye's that is not streaming; kUnpaired when both stream, and there was no pair for three periods.
  hal::CameraState state() const noexcept override { return state_; }

  const V4l2Camera& left() const noexcept { return left_; }
  const V4l2Camera& right() const noexcept { return right_; }
  const PairStats& stats() const noexcept { return stats_; }
  Duration tolerance() const noexcept { return tolerance_; }
  /// Pairs exposed within the second before `now` [1/s]; up to 128.
  double rate(Time now) const noexcept;

 private:
  struct Match {
    std::size_t left = 0, right = 0;  ///< places among those that wait
  };
  std::optional<Match> newest_match() const noexcept;
  void drop(V4l2Camera& eye, const V4l2Camera& other, std::size_t count) noexcept;
  void drop_hopeless() noexcept;
  void count_pair(Time left, Duration difference) noexcept;
  void record(Duration difference) noexcept;
  bool hand_over(hal::StereoFrame& into);
  void judge(Time now) noexcept;

  const hal::Clock& clock_;
  V4l2Camera left_, right_;
  Duration tolerance_;
  hal::StereoFrame spare_;  ///< decoded into, so that the caller's stays whole when one eye's image is not
  PairStats stats_;
  hal::CameraState state_ = hal::CameraState::kStarting;
  Time paired_at_;                     ///< when there was a pair, or an eye was not streaming
  std::array<Time, 128> exposures_{};  ///< left eye's, of the newest pairs, in a ring
};

}  // namespace headway::drivers
