// How a robot is, as of the frame loop's newest order; a plain value.
#pragma once

#include <array>
#include <optional>

#include "hal/head.h"
#include "hal/walker.h"
#include "runtime/frame_loop.h"

namespace headway::app {

const char* text_of(hal::HeadHealth health);
const char* text_of(hal::WalkerHealth health);

/// How the robot is, as of the frame loop's newest order.
struct LiveStatus {
  Time stamp{};
  runtime::MissionState state = runtime::MissionState::kStarting;
  std::array<char, 200> reason{};  ///< why it stopped; ends with 0
  Pose2 base;                      ///< where it believes to stand or to step to next, in the map
  hal::HeadHealth head = hal::HeadHealth::kStarting;
  hal::HeadAngles angles;  ///< as the drives report them
  hal::WalkerHealth walker = hal::WalkerHealth::kStarting;
  runtime::FrameLevel level = runtime::FrameLevel::kFull;  ///< how much is done with each frame
  bool at_rest = true;
  std::optional<nav::Goal> goal;  ///< that it has, had or gave up
  double short_of_goal = 0;       ///< as Mission::short_of_goal()
  runtime::FrameLoopCounters frames;
  runtime::MissionCounters mission;
  runtime::StageTimes times;  ///< of the newest frame
};

/// In the frame loop's thread.
LiveStatus live_status(const runtime::FrameLoop& frames, const runtime::Mission& mission,
                       const runtime::BusReport& bus);

}  // namespace headway::app
