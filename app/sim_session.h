// One run of the whole program against the simulated robot: builds both, steps them together, and judges the
// result by the simulator's truth.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/body_mask_check.h"
#include "app/fault_check.h"
#include "app/live_status.h"
#include "app/precision.h"
#include "app/reaction_check.h"
#include "app/robot_file.h"
#include "app/simulated_robot.h"
#include "app/taps.h"
#include "drivers/can_walker.h"
#include "drivers/cia402_head.h"
#include "runtime/bus_loop.h"
#include "runtime/frame_loop.h"
#include "runtime/lockstep.h"
#include "runtime/operator_line.h"
#include "sim_hal/robot.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_camera.h"
#include "sim_hal/sim_depth_camera.h"
#include "sim_hal/world.h"

namespace headway::app {

struct SimOptions : SimulatedRobotOptions {
  bool range_mode = false;  ///< depth straight from the ray caster instead of two images and a matcher
  bool replan = true;
  bool localise = true;             ///< false: odometry is taken for the truth, whatever the robot file says
  std::optional<nav::Goal> goal;    ///< instead of the world's
  bool near = false;                ///< where no way leads to the goal, as near as it gets will do
  Duration longest = seconds(400);  ///< simulated time after which a run is given up
  bool waits = false;               ///< for goals from outside, in place of walking to one
  runtime::Recorder* recorder = nullptr;  ///< writes down what happens; null: nobody does
};

/// How near the true base must be to the goal (or to the place nearest to it, when that will do) to have
/// arrived: what a person would call being there. The mission's own tolerances are tighter, for it knows the
/// truth by odometry only.
constexpr double kArrivedWithin = 0.10;     ///< [m]
constexpr double kArrivedWithinYaw = 0.10;  ///< [rad], where a yaw is wished

/// A robot that has stood for so long without taking a new view waits for somebody: the run is over.
constexpr Duration kStandstill = seconds(30);

/// How a run ended.
struct SimOutcome {
  bool arrived = false;  ///< at rest, and the true base is where it should be
  bool fallen = false;
  std::optional<sim::Collision> collision;
  /// "arrived", "missed" (it believes so, and is elsewhere), "stopped", "collision", "fall" or "time"
  std::string end;
  std::string reason;        ///< why it stopped, for people
  double goal_error = 0;     ///< true distance of the base from the goal [m]
  double short_of_goal = 0;  ///< how far from it the nearest place lies, where no way leads to it [m]
  std::optional<double> goal_yaw_error;  ///< [rad]; nothing without a wished yaw
  double odometry_error = 0;             ///< true base against where odometry has it [m]
  double map_error = 0;                  ///< and against where it is believed to be in the map [m]
  double walked = 0;                     ///< way of the base [m]
  double seconds = 0;                    ///< simulated
};

/// When the mission went over to another state, and where the robot believed to be.
struct SimEvent {
  Time time{};
  runtime::MissionState state{};
  Pose2 base;
};

/// One kind of finding about the cameras' sight: as it was first said, and in how many frames.
struct SimSightFinding {
  vision::SightFinding first;
  Time time{};
  int frames = 0;
};

/// Samples of the run for pictures and reports.
struct SimTrail {
  static constexpr Duration kPeriod = seconds(0.1);
  std::vector<Pose2> truth, believed;  ///< base poses
};

class SimSession {
 public:
  /// Throws InputError when world and robot do not fit (start or goal outside the floor, goal in an
  /// obstacle).
  SimSession(const Robot& robot, const sim::World& world, const SimOptions& options);

  /// Sets the robot up in a map that it knows from before; ahead of run(). Throws InputError when the map's
  /// voxels are not the robot's.
  void restore(const nav::SavedMap& known) { frames_.restore(known); }

  /// Called after each frame's work.
  void observe(runtime::FrameObserver observer) { observer_ = std::move(observer); }
  /// Called ten times per simulated second.
  void on_progress(std::function<void()> report) { progress_ = std::move(report); }

  /// Another goal, where the last run has ended at rest. What is kept of the way for pictures begins anew.
  void send_to(const nav::Goal& goal);
  /// Until the robot has arrived, stopped, collided or fallen, or for options().longest.
  SimOutcome run();
  /// Until it has collided or fallen, or `go_on`, asked after each period, says no.
  SimOutcome run_while(const std::function<bool()>& go_on);
  /// For who gives orders between two periods.
  runtime::OperatorLine& line() { return line_; }
  LiveStatus status() const { return live_status(frames_, mission_, links_->report.value()); }

  Time now() const { return clock_.now(); }
  const nav::Goal& goal() const { return goal_; }
  const SimOptions& options() const { return options_; }
  const Robot& robot() const { return robot_; }
  const sim::Scene& scene() const { return scene_; }
  const sim::SimRobot& body() const { return body_; }
  const runtime::Mapper& mapper() const { return mapper_; }
  const runtime::Mission& mission() const { return mission_; }
  const runtime::BusLoop& bus_loop() const { return bus_loop_; }
  const runtime::FrameLoop& frame_loop() const { return frames_; }
  const runtime::Links& links() const { return *links_; }
  const drivers::CanWalker& walker() const { return walker_; }
  const PrecisionCheck::Result& precision() const { return precision_.result(); }
  const ReactionCheck& reactions() const { return reactions_; }
  const BodyMaskCheck& body_mask() const { return body_mask_; }
  const FaultCheck& faults() const { return faults_; }
  const std::vector<runtime::StepRecord>& steps() const { return steps_; }  ///< landings in the map frame
  const SimTrail& trail() const { return trail_; }
  const std::vector<SimEvent>& events() const { return events_; }
  const std::vector<SimSightFinding>& sight_findings() const { return sight_findings_; }

 private:
  void step();
  runtime::Eyes& make_eyes();
  void move_world(Time now);
  void watch(const runtime::FrameSnapshot& snapshot);
  bool in_sight(const Eigen::Vector3d& point) const;
  void note();
  void note_faults();
  void note_progress();
  const sim::FaultSchedule* fault_schedule() const;
  runtime::Lockstep::Starved starved(Time now) const;
  void note_sight(Time exposure);
  SimOutcome judge(std::string end) const;

  Robot robot_;
  nav::Goal goal_;
  SimOptions options_;
  hal::ManualClock clock_;
  hal::MonotonicClock stopwatch_;
  sim::Scene scene_;
  sim::SimRobot body_;
  Taps taps_;
  hal::CanBus& bus_;
  std::unique_ptr<sim::SimStereoCamera> stereo_camera_;
  std::unique_ptr<sim::SimDepthCamera> depth_camera_;
  std::unique_ptr<runtime::Eyes> eyes_;
  const runtime::StereoEyes* stereo_eyes_ = nullptr;  ///< the same, but in range mode
  PairSight sight_;                                   ///< of the views
  drivers::Cia402Head head_;
  drivers::CanWalker walker_;
  std::unique_ptr<runtime::Links> links_;
  runtime::OperatorLine line_;
  runtime::Mapper mapper_;
  runtime::Mission mission_;
  runtime::BusLoop bus_loop_;
  runtime::FrameLoop frames_;
  runtime::Lockstep lockstep_;
  runtime::FrameObserver observer_;
  std::function<void()> progress_;
  PrecisionCheck precision_;
  sim::Onlooker onlooker_;  ///< the robot, as things that set off before its eyes know it
  ReactionCheck reactions_;
  BodyMaskCheck body_mask_;
  FaultCheck faults_;
  Time progress_at_{};  ///< when it last walked or took a view
  std::size_t views_ = 0;
  std::vector<runtime::StepRecord> steps_;
  SimTrail trail_;
  std::vector<SimEvent> events_;
  std::vector<SimSightFinding> sight_findings_;
};

}  // namespace headway::app
