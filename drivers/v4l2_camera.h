// One V4L2 camera: its newest frames, stamped with the middle of their exposure, and its way back after
// whatever goes wrong.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/back_off.h"
#include "drivers/frame_judge.h"
#include "drivers/jpeg_decoder.h"
#include "drivers/v4l2_stream.h"
#include "hal/camera.h"
#include "hal/clock.h"
#include "hal/frame.h"

namespace headway::drivers {

/// Has no thread: one thread, the frame loop's, calls poll() at least once per frame, and everything happens
/// within that call. None waits for a frame. After construction none throws or allocates, but for an image
/// that does not fit and what libjpeg-turbo needs.
///
/// Without a usable frame for three periods the stream is restarted; when that has helped twice in vain, or
/// the device fails, all is torn down and opened again, first after 0.5 s, then ever later, up to 5 s.
class V4l2Camera {
 public:
  /// A frame that can be taken.
  struct Waiting {
    Time exposure{};             ///< its middle
    std::uint64_t sequence = 0;  ///< counts the camera's frames since the program began; a gap is a lost one
    FilledBuffer buffer;
  };
  /// So that the driver always has two buffers to fill.
  static constexpr std::size_t kMostWaiting = 2;

  /// Opens, sets up and starts the camera. Throws InputError as V4l2CameraConfig::validate, and where the
  /// device is not there or not as it is to be; Error where it fails. Clock and calls must outlive it.
  V4l2Camera(const V4l2CameraConfig& config, const hal::Clock& clock, DeviceCalls& calls = kernel_calls());

  /// Brings in what the driver has filled, and looks after the stream.
  void poll() noexcept;
  /// Frames that wait, the oldest first. With more than kMostWaiting the oldest is skipped.
  std::span<const Waiting> waiting() const noexcept { return {waiting_.data(), waiting_count_}; }
  /// Gives the oldest back without a look at it. Needs one that waits, as take() does.
  void skip() noexcept;
  /// Copies or decodes the oldest, then gives it back. False when it cannot be decoded; then what `into`
  /// holds means nothing. The first for all formats but Z16, the second, which fills the image only, for that
  /// one.
  bool take(hal::GrayImage& into);
  bool take(hal::DepthFrame& into);

  const hal::CameraStats& stats() const noexcept { return stats_; }
  /// As the camera was set when it was last opened.
  const V4l2Settings& settings() const noexcept { return settings_; }
  const V4l2CameraConfig& config() const noexcept { return config_; }
  /// From frame to frame, as the driver says; one second when it does not.
  Duration period() const noexcept { return settings_.period.value_or(seconds(1)); }
  /// What went wrong last, in one line; empty when nothing has.
  std::string fault() const;

 private:
  void open_again(Time now) noexcept;
  void accept(V4l2Stream stream, Time now) noexcept;
  void admit(const FilledBuffer& buffer, Time now) noexcept;
  void keep(const FilledBuffer& buffer, const FrameVerdict& verdict, Time now) noexcept;
  void count(FrameKind unusable) noexcept;
  void watch(Time now) noexcept;
  Duration patience() const noexcept;
  void give_up(const V4l2Fault& fault, hal::CameraState state, Time now) noexcept;
  void give_back(const FilledBuffer& buffer) noexcept;
  Waiting pop() noexcept;
  template <class Read>
  bool take_oldest(Read read);

  V4l2CameraConfig config_;
  const hal::Clock& clock_;
  DeviceCalls& calls_;
  JpegDecoder jpeg_;
  std::optional<V4l2Stream> stream_;
  V4l2Settings settings_;
  FrameJudge judge_;
  hal::CameraStats stats_;
  V4l2Fault fault_;

  std::array<Waiting, kMostWaiting> waiting_{};
  std::size_t waiting_count_ = 0;
  std::uint64_t sequence_ = 0;

  Time good_at_{};              ///< when a usable frame came, or the stream was started
  bool is_first_ = true;        ///< no usable frame has come since
  int restarts_in_vain_ = 0;    ///< since the last usable frame
  int undecodable_ = 0;         ///< frames in a row
  hal::CameraState trouble_{};  ///< why frames that came were not usable; kSilent: none came
  bool has_worked_ = true;      ///< since it was opened; when constructed there is no doubt of it
  BackOff retry_;
};

}  // namespace headway::drivers
