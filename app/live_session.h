// The whole program on a real clock, with whatever bus and eyes it is given: the robot's own, or those of a
// simulated one behind real wires.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "app/live_status.h"
#include "app/robot_file.h"
#include "app/taps.h"
#include "drivers/can_walker.h"
#include "drivers/cia402_head.h"
#include "hal/exchange.h"
#include "runtime/bus_loop.h"
#include "runtime/frame_loop.h"
#include "runtime/live_loops.h"
#include "runtime/operator_line.h"

namespace headway::app {

/// Where the robot stands by its control computer's odometry; nothing when that does not tell within
/// `longest`. Only listens. By a clock that sleeps.
std::optional<Pose2> hear_where_it_stands(hal::CanBus& bus, hal::Clock& clock, Duration longest);

struct LiveOptions {
  Pose2 start;                    ///< where the robot stands in its odometry frame, which the map begins as
  Eigen::Vector2d floor{20, 20};  ///< size of the floor in use around the start [m]
  std::optional<nav::Goal> goal;
  double frame_rate = 15;                 ///< of the cameras [Hz]
  runtime::Recorder* recorder = nullptr;  ///< writes down what happens; null: nobody does
};

class LiveSession {
 public:
  /// Bus, eyes and clock must outlive it. Throws InputError for a start or goal that the floor does not hold.
  LiveSession(const Robot& robot, const LiveOptions& options, hal::CanBus& bus, runtime::Eyes& eyes,
              hal::Clock& clock);

  void start() { loops_.start(); }
  /// Brings the robot to rest, ends the loops and leaves the head's drives in order. True when it stands.
  bool stop() noexcept;
  /// As LiveLoops::left_hanging().
  const char* left_hanging() const noexcept { return loops_.left_hanging(); }

  /// As OperatorLine::go(). Throws InputError also where the floor in use does not hold the goal.
  void go(const nav::Goal& goal);
  void stay() { line_.stay(); }
  void reset() { line_.reset(); }
  runtime::OperatorLine& line() { return line_; }
  /// Shown each frame's work, in the frame loop's thread; ahead of start().
  void observe(runtime::FrameObserver observer) { observer_ = std::move(observer); }
  const Robot& robot() const { return robot_; }
  /// Of the floor in use.
  const nav::FloorGrid& floor_grid() const { return mapper_.floor().grid; }

  /// True, and `into` filled, when there is news since the last call.
  bool look(LiveStatus& into);
  /// The same of the safety state's changes, one after the other.
  bool look(runtime::SafetyChange& into) { return links_->safety.pop(into); }
  /// As of the bus loop's newest cycle.
  const runtime::SafetyReport& safety() const { return line_.safety(); }
  std::optional<std::string> failure() const { return loops_.failure(); }
  std::string refusal() const { return loops_.refusal(); }
  /// As LiveLoops::hanging().
  std::optional<std::string> hanging(Time now) const { return loops_.hanging(now); }
  const runtime::LiveLoops& loops() const { return loops_; }

  // Once stopped:
  const runtime::Mapper& mapper() const { return mapper_; }
  const runtime::Mission& mission() const { return mission_; }
  const runtime::FrameLoop& frame_loop() const { return frames_; }
  const runtime::BusLoop& bus_loop() const { return bus_loop_; }
  const drivers::CanWalker& walker() const { return walker_; }

 private:
  void report();

  Robot robot_;
  LiveOptions options_;
  hal::Clock& clock_;
  Taps taps_;
  hal::CanBus& bus_;
  drivers::Cia402Head head_;
  drivers::CanWalker walker_;
  std::unique_ptr<runtime::Links> links_;
  runtime::OperatorLine line_;
  runtime::Mapper mapper_;
  runtime::Mission mission_;
  runtime::BusLoop bus_loop_;
  runtime::FrameLoop frames_;
  runtime::FrameObserver observer_;
  hal::NewestSlot<LiveStatus> status_;
  runtime::LiveLoops loops_;
};

}  // namespace headway::app
