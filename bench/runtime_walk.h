// A walk of the simulated robot through a room that it has explored, with all that its frame loop was given,
// so that the same frames can be worked on again at the cameras' own pace.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "app/robot_file.h"
#include "hal/camera.h"
#include "hal/clock.h"
#include "runtime/frame_loop.h"
#include "runtime/second_processor.h"

namespace headway::bench {

/// Frame loop, map and mission on any camera.
struct FrameSide {
  FrameSide(const app::Robot& robot, const Pose2& start, hal::StereoCamera& camera, double frame_rate);

  hal::MonotonicClock stopwatch;
  runtime::SecondProcessor second;
  runtime::StereoEyes eyes;
  std::unique_ptr<runtime::Links> links;
  runtime::Mapper mapper;
  runtime::Mission mission;
  runtime::FrameLoop frames;
};

/// What came to the frame loop since the frame before, and what it made of it.
struct Given {
  Time now{};
  hal::StereoFrame frame;
  std::vector<hal::ChestSample> chest;
  std::vector<runtime::HeadSample> head;
  runtime::BusReport report;
  runtime::MissionState then = runtime::MissionState::kStarting;
};

struct RecordedWalk {
  app::Robot robot;
  Pose2 start;
  double frame_rate = 15;  ///< [Hz]
  nav::Goal there, back;
  std::vector<Given> frames;
  std::size_t turned = 0;  ///< from this frame on it walks back, through what it has explored
};

/// From the laboratory's start to the middle of the room, and back, seen through two cameras of 640x480, in a
/// map of 2 cm. Throws Error when the robot does not come back.
RecordedWalk record_walk();

/// Gives the frames again, in their order.
class PlayedWalk final : public hal::StereoCamera {
 public:
  explicit PlayedWalk(const RecordedWalk& walk)
      : walk_(walk), side_(walk.robot, walk.start, *this, walk.frame_rate) {}
  bool take_newest(hal::StereoFrame& into) override;
  /// The work on the next frame. Throws Error when it comes out otherwise than it was recorded.
  void work();
  bool over() const { return next_ == walk_.frames.size(); }
  /// The frame worked on last: how long that took in all [s], and on the processor; its stages; and whether
  /// it was on the way back.
  double seconds() const { return seconds_; }
  double cpu_seconds() const { return cpu_seconds_; }
  const runtime::StageTimes& stages() const { return side_.frames.times(); }
  bool walks_back() const {
    return next_ > walk_.turned && side_.mission.state() == runtime::MissionState::kWalk;
  }
  const runtime::MissionCounters& counters() const { return side_.mission.counters(); }

 private:
  const RecordedWalk& walk_;
  hal::MonotonicClock stopwatch_;
  std::size_t next_ = 0;
  const hal::StereoFrame* shown_ = nullptr;
  double seconds_ = 0, cpu_seconds_ = 0;
  FrameSide side_;
};

}  // namespace headway::bench
