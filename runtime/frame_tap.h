// What the frame loop hands to the recorder: all that its work took in and what came of it, so that the work
// can be done again, and what a viewer shows of it.
#pragma once

#include <atomic>
#include <cstdint>

#include "hal/camera.h"
#include "hal/clock.h"
#include "runtime/frame_loop.h"
#include "runtime/intake_observer.h"
#include "runtime/row_queue.h"

namespace headway::runtime {

class FrameTap final : public IntakeObserver {
 public:
  /// `picture_bytes`: of the cameras' images, so that room for them is made ahead.
  explicit FrameTap(std::size_t picture_bytes) : rows_(kRowBytes), pictures_(picture_bytes + kRowBytes) {}

  // In the frame loop's thread (a goal: also ahead of it):
  void took(const hal::StereoFrame& frame);
  void took(const hal::DepthFrame& frame);
  void read(Time stopwatch) { work_.stopwatch_ns.push_back(stopwatch.time_since_epoch().count()); }
  void begins(Time now, FrameLevel level) override;
  void takes(const hal::ChestSample& sample) override;
  void takes(const HeadSample& sample) override;
  void takes(const GoalOrder& order) override;
  void takes(const LookOrder& order) override;
  void ends(const MotionOrder* order, const BusReport& report, bool frame_waits) override;
  void see(const FrameSnapshot& snapshot);
  void set(const nav::Goal& goal, Time now);

  // In the recorder's:
  /// Takes out all that is there, in the order in which it came.
  template <class Visit>
  void drain(Visit&& visit) {
    const auto pictures_before = [&](std::uint64_t ticket) {
      for (const auto* slot = pictures_.front(); slot != nullptr && slot->ticket < ticket;
           slot = pictures_.front()) {
        visit(slot->row());
        pictures_.drop_front();
      }
    };
    while (const auto* slot = rows_.front()) {
      pictures_before(slot->ticket);
      visit(slot->row());
      rows_.drop_front();
    }
  }
  /// A new file begins: it is to have the map.
  void want_map() { map_wanted_ = true; }
  /// The two counts that are its own.
  void count(recorded::Drops& drops) const;

 private:
  static constexpr std::size_t kRowBytes = 8192;
  static constexpr Duration kMapEvery = seconds(1);

  template <class Queue, class Message>
  void put(Queue& queue, Topic topic, Time time, const Message& message);
  void put_image(Topic topic, Time exposure, std::uint32_t width, std::uint32_t height, const char* encoding,
                 std::span<const std::uint8_t> bytes);
  void put_poses(const FrameSnapshot& snapshot);
  void put_path(const FrameSnapshot& snapshot);
  void put_mission(const Mission& mission);

  RowQueue<1024> rows_;
  RowQueue<64> pictures_;
  std::uint64_t ticket_ = 0;
  std::array<std::uint32_t, kTopics.size()> next_{};  ///< numbers within each topic
  Time now_{};
  recorded::Work work_;
  bool first_ = true, waited_ = false;
  std::uint32_t floor_sum_ = 0, map_sum_ = 0;
  Time map_at_{};
  bool map_put_ = false, path_put_ = false;
  recorded::Mission mission_;
  std::atomic<bool> map_wanted_{true};
};

/// Cameras and a stopwatch that show the tap what the frame loop gets from them. All must outlive them.
class TappedStereoCamera final : public hal::StereoCamera {
 public:
  TappedStereoCamera(hal::StereoCamera& camera, FrameTap& tap) : camera_(camera), tap_(tap) {}
  bool take_newest(hal::StereoFrame& into) override {
    const bool taken = camera_.take_newest(into);
    if (taken) tap_.took(into);
    return taken;
  }
  hal::CameraState state() const noexcept override { return camera_.state(); }

 private:
  hal::StereoCamera& camera_;
  FrameTap& tap_;
};

class TappedDepthCamera final : public hal::DepthCamera {
 public:
  TappedDepthCamera(hal::DepthCamera& camera, FrameTap& tap) : camera_(camera), tap_(tap) {}
  bool take_newest(hal::DepthFrame& into) override {
    const bool taken = camera_.take_newest(into);
    if (taken) tap_.took(into);
    return taken;
  }
  hal::CameraState state() const noexcept override { return camera_.state(); }

 private:
  hal::DepthCamera& camera_;
  FrameTap& tap_;
};

class TappedStopwatch final : public hal::Clock {
 public:
  TappedStopwatch(const hal::Clock& clock, FrameTap& tap) : clock_(clock), tap_(tap) {}
  Time now() const noexcept override {
    const Time t = clock_.now();
    tap_.read(t);
    return t;
  }
  void sleep_until(Time) noexcept override {}
  Time at_monotonic(Time stamp) const noexcept override { return clock_.at_monotonic(stamp); }

 private:
  const hal::Clock& clock_;
  FrameTap& tap_;
};

}  // namespace headway::runtime
