// Lets a recorder, where there is one, see what passes between a session's parts.
#pragma once

#include <optional>

#include "runtime/bus_loop.h"
#include "runtime/frame_loop.h"
#include "runtime/recorder.h"

namespace headway::app {

/// Each of the first four is asked for once. What they return lives as long as this.
class Taps {
 public:
  /// Null: everything stays as it is.
  explicit Taps(runtime::Recorder* recorder) : recorder_(recorder) {}

  hal::CanBus& bus(hal::CanBus& bus, const hal::Clock& clock) {
    if (!recorder_) return bus;
    return bus_.emplace(bus, recorder_->bus(), clock);
  }
  hal::StereoCamera& camera(hal::StereoCamera& camera) {
    if (!recorder_) return camera;
    return stereo_.emplace(camera, recorder_->frames());
  }
  hal::DepthCamera& camera(hal::DepthCamera& camera) {
    if (!recorder_) return camera;
    return depth_.emplace(camera, recorder_->frames());
  }
  const hal::Clock& stopwatch(const hal::Clock& clock) {
    if (!recorder_) return clock;
    return stopwatch_.emplace(clock, recorder_->frames());
  }
  void watch(runtime::BusLoop& bus, runtime::FrameLoop& frames) {
    if (!recorder_) return;
    bus.show(recorder_->bus());
    frames.show(recorder_->frames());
  }
  void see(const runtime::FrameSnapshot& snapshot) {
    if (recorder_) recorder_->frames().see(snapshot);
  }
  void set(const nav::Goal& goal, Time now) {
    if (recorder_) recorder_->frames().set(goal, now);
  }

 private:
  runtime::Recorder* recorder_;
  std::optional<runtime::TappedBus> bus_;
  std::optional<runtime::TappedStereoCamera> stereo_;
  std::optional<runtime::TappedDepthCamera> depth_;
  std::optional<runtime::TappedStopwatch> stopwatch_;
};

}  // namespace headway::app
