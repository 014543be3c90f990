// Does the frame loop's work again from a recording: the same frames, samples and reports at the same times
// in the same order, and looks whether it comes to the same orders, bit by bit.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "hal/camera.h"
#include "hal/clock.h"
#include "runtime/frame_loop.h"
#include "runtime/intake_observer.h"
#include "runtime/topics.h"

namespace headway::runtime {

/// Gives each frame once, when it has been offered.
template <class Camera, class Frame>
class OfferedCamera final : public Camera {
 public:
  void offer(Frame frame) { frame_ = std::move(frame); }
  bool take_newest(Frame& into) override {
    if (!frame_) return false;
    into = *std::exchange(frame_, std::nullopt);
    return true;
  }

 private:
  std::optional<Frame> frame_;
};
using OfferedStereoCamera = OfferedCamera<hal::StereoCamera, hal::StereoFrame>;
using OfferedDepthCamera = OfferedCamera<hal::DepthCamera, hal::DepthFrame>;

/// Shows what a stopwatch once showed, reading by reading; the last one again when there are no more.
class RecordedStopwatch final : public hal::Clock {
 public:
  void load(const std::vector<std::int64_t>& readings_ns) {
    readings_.assign(readings_ns.begin(), readings_ns.end());
  }
  Time now() const noexcept override {
    if (!readings_.empty()) {
      last_ = Time(Duration(readings_.front()));
      readings_.pop_front();
    }
    return last_;
  }
  void sleep_until(Time) noexcept override {}

 private:
  mutable std::deque<std::int64_t> readings_;
  mutable Time last_{};
};

struct ReplayResult {
  std::uint64_t works = 0, frames = 0, orders = 0;  ///< done again
  Time first{}, last{};                             ///< of those works
  /// The first order, or floor map, that is not the recorded one: of which work, and what is different.
  std::optional<std::string> difference;
  /// Why it could not be done to the recording's end.
  std::optional<std::string> missing;
  bool same() const { return !difference && !missing && orders > 0; }
};

/// Fed with a recording's rows in their order. The loop, and all that it is made of, is new, is that of the
/// recording's configuration, and outlives this.
class Replay final : public IntakeObserver {
 public:
  struct Parts {
    FrameLoop& frames;
    Mission& mission;
    Links& links;
    RecordedStopwatch& stopwatch;
    OfferedStereoCamera* stereo = nullptr;  ///< one of the two
    OfferedDepthCamera* depth = nullptr;
  };
  explicit Replay(const Parts& parts);

  /// Rows of other topics are passed over. False when there is nothing more to be done: something is missing.
  /// Throws recording::CdrError for a row that is no such message.
  bool take(const Row& row);
  const ReplayResult& result() const { return result_; }
  /// Shown each frame's work too.
  void observe(FrameObserver observer) { observer_ = std::move(observer); }

 private:
  void begins(Time, FrameLevel) override {}
  void takes(const hal::ChestSample&) override {}
  void takes(const HeadSample&) override {}
  void takes(const GoalOrder&) override {}
  void takes(const LookOrder&) override {}
  void ends(const MotionOrder* order, const BusReport& report, bool frame_waits) override;

  bool work(const recorded::Work& work);
  bool offer_frame(std::uint64_t sequence);
  bool miss(std::string what);
  void compare(const recorded::Work& work);

  Parts parts_;
  std::optional<std::uint32_t> next_;  ///< work
  std::vector<recording::ros::Image> pictures_;
  std::optional<MotionOrder> order_;  ///< of the work done last
  std::uint32_t floor_sum_ = 0;
  FrameObserver observer_;
  ReplayResult result_;
};

}  // namespace headway::runtime
