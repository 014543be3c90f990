// What the robot is about: look around, wait for a goal, walk there while watching the floor, arrive or stop.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/head_kinematics.h"
#include "nav/footsteps.h"
#include "nav/next_view.h"
#include "nav/walking/forecast.h"
#include "runtime/current_walk.h"
#include "runtime/floor_gate.h"
#include "runtime/gaze.h"
#include "runtime/links.h"
#include "runtime/mapper.h"
#include "runtime/refusals.h"
#include "runtime/second_look.h"
#include "runtime/way_finder.h"
#include "vision/polytope.h"

namespace headway::runtime {

enum class MissionState : std::uint8_t {
  kStarting,    ///< the head's drives and the control computer are not ready yet
  kLookAround,  ///< at rest, looking in all directions
  kWaitGoal,    ///< at rest, nothing to do
  kWalk,        ///< plans each frame and walks
  kLookAhead,   ///< at rest on the way, looking at floor that has to be seen first
  kArrived,     ///< at rest at the goal
  kStopped,     ///< at rest, the goal is given up: see reason()
};
const char* name(MissionState state);

struct MissionConfig {
  nav::GaitLimits gait;
  nav::BodyOutline outline;
  nav::PlannerConfig planner;
  nav::Execution execution = nav::Execution::kSteps;
  FloorGateConfig gate;
  hal::HeadKinematics neck;
  hal::HeadLimits head;
  vision::Polytope field;  ///< of the rig, in the left camera's optical frame
  /// To look around where most is to be seen, until nothing is left to gain. Without it: at the viewpoints.
  std::optional<nav::NextViewConfig> next_view;
  /// To look in turn when all that is known is to be looked at again: things may have moved.
  std::vector<hal::HeadAngles> viewpoints;
  int frames_per_view = 2;
  bool replan =
      true;  ///< false: follow the first plan, whatever is seen later (to show what replanning gains)
  double look_distance = 1.25;   ///< along the way ahead of the base [m]
  double goal_tolerance = 0.06;  ///< [m]
  double yaw_tolerance = 0.06;   ///< [rad]
  int fewer_steps = 6;  ///< a new plan replaces one that is still good when it saves more steps than this
  int attempts = 3;     ///< looks around from one place, or walks refused, before the goal is given up
  /// Without a frame that shows something, or without a head that turns, before it is given up.
  Duration longest_blind = seconds(10);
};

/// What the mission knows when a frame has been worked on.
struct MissionInput {
  Time now{};
  Time last_look = nav::kNever;  ///< exposure of the newest frame that told the map something
  std::string blind;             ///< why this frame told it nothing; empty when it did
  bool faulty = false;           ///< it could not be used at all: a look that does not count
  bool placed = true;            ///< it is known where in the map the robot is
  hal::HeadAngles head;          ///< at this frame's exposure
  Eigen::Isometry3d map_from_chest = Eigen::Isometry3d::Identity();  ///< at this frame's exposure
  const BusReport& bus;
  const Mapper& mapper;
};

struct MissionCounters {
  int plans = 0;    ///< searches
  int replans = 0;  ///< plans that changed steps not yet committed
  int threats = 0;  ///< walks stopped for an obstacle on steps that were committed
  int pauses = 0;   ///< rests on the way to look at the floor
  int look_arounds = 0;
};

/// Pure decision: no clock, no devices. One update per frame.
class Mission {
 public:
  Mission(const MissionConfig& config, const nav::FloorGrid& grid);

  /// A new destination, in place of any other. Taken up when the robot has looked around, which it does again
  /// where it has arrived or stopped; while it walks, with the next frame.
  void set_goal(const nav::Goal& goal);
  /// The same, by somebody who knew of so many safety stops (SafetyReport::stops): void where there were
  /// more.
  void set_goal(const nav::Goal& goal, std::uint32_t after);

  /// Looks there, or around, where the robot rests and pursues no goal; anywhere else it counts for nothing.
  void look(const LookOrder& order);

  /// Decides what the robot does until the next frame.
  MotionOrder update(const MissionInput& input);

  MissionState state() const { return state_; }
  /// Why it stopped; or, where it arrived only near the goal, how near and why.
  const std::string& reason() const { return reason_; }
  /// How far from the goal the place lies that the newest plan leads to; 0 where it leads to the goal [m].
  double short_of_goal() const;
  bool over() const { return state_ == MissionState::kArrived || state_ == MissionState::kStopped; }
  const std::optional<nav::Goal>& goal() const { return goal_; }
  const std::optional<CurrentWalk>& walk() const { return walk_; }
  std::size_t views_taken() const { return views_taken_; }  ///< of looking around, since the start
  const MissionCounters& counters() const { return counters_; }

 private:
  MotionOrder decide(const MissionInput& input);
  std::optional<std::string> hopeless(const MissionInput& input);
  std::optional<std::string> blind_too_long(const MissionInput& input);
  MotionOrder starting(const MissionInput& input);
  MotionOrder look_around(const MissionInput& input);
  MotionOrder walk_on(const MissionInput& input);
  MotionOrder look_ahead(const MissionInput& input);
  MotionOrder rest(const MissionInput& input) const;

  void begin_look_around();
  void begin_look_again();
  Tour next_look(const MissionInput& input);
  void plan(const MissionInput& input);
  bool worth_changing(const nav::Walk& candidate, const nav::Committed& committed,
                      const nav::FloorMap& floor) const;
  bool threatened(const MissionInput& input) const;
  [[nodiscard]] bool keep_up(const nav::Committed& committed);
  bool stable(const nav::Walk& candidate);
  void adopt(nav::Path path, nav::Walk walk, const nav::Committed& committed);
  bool at_goal(const nav::Committed& committed) const;
  MotionOrder held_up(const MissionInput& input, const Gate& gate);
  Gate check_gate(const MissionInput& input) const;
  bool look_again_for_a_way(const MissionInput& input);
  void end_second_look(const MissionInput& input);
  void give_up(std::string reason);
  hal::HeadAngles gaze(const MissionInput& input, const Gate& gate) const;

  MissionConfig config_;
  WayFinder ways_;
  FloorGate gate_;
  MissionState state_ = MissionState::kStarting;
  std::optional<nav::Goal> goal_;
  std::uint32_t stops_ = 0,
                goal_after_ = 0;  ///< safety stops: known of, and known of when the goal was given
  Time seen_{};                   ///< when a picture that can be used came last
  std::string reason_;
  std::optional<nav::NextView> next_view_;
  bool exploring_ = false;                 ///< looks around for what is unseen, not through the viewpoints
  std::vector<Eigen::Isometry3d> looked_;  ///< poses of the left camera on this look around
  Tour tour_;
  hal::HeadAngles look_;
  std::optional<CurrentWalk> walk_;
  nav::WalkForecaster forecaster_;  ///< has taken in the session's steps before `forecast_from_`
  std::uint8_t forecast_session_ = 0;
  std::uint32_t forecast_from_ = 0;
  std::string unstable_;  ///< why the newest plan cannot be walked; empty when it can
  nav::PlanResult last_plan_;
  bool planned_once_ = false;
  bool finding_place_ = false;
  // When last, or since when there is this goal:
  std::optional<Time> sight_;   ///< a frame came that showed something
  std::optional<Time> turned_;  ///< the head was ready to turn
  Refusals refusals_;
  int fruitless_ = 0;  ///< looks without a step gained
  Time held_up_{};     ///< since when
  SecondLook second_look_;
  std::size_t views_taken_ = 0;
  MissionCounters counters_;
};

}  // namespace headway::runtime
