// The work between two frames: look, map, floor, plan. One direction, newest frame wins.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "hal/clock.h"
#include "hal/pose_history.h"
#include "nav/cold_map_file.h"
#include "nav/levelling.h"
#include "runtime/eyes.h"
#include "runtime/frame_budget.h"
#include "runtime/intake_observer.h"
#include "runtime/links.h"
#include "runtime/localisation.h"
#include "runtime/mapper.h"
#include "runtime/mission.h"
#include "runtime/stage_times.h"

namespace headway::runtime {

struct FrameLoopConfig {
  hal::HeadKinematics neck;
  Duration camera_time_offset{};      ///< added to the camera's stamps, to come to the bus's time
  Duration pose_wait = seconds(0.1);  ///< a frame whose pose has not come by then is skipped
  Duration pose_gap = seconds(0.1);   ///< poses are not interpolated over a gap wider than this
  Duration silence = seconds(1);      ///< without a frame, after which the mission is told of it
  FrameBudgetConfig budget{};
  double near = 3.0;  ///< when there is time for no more, nothing is taken in from farther away [m]
  nav::LevellingConfig levelling{};
  LocalisationConfig localisation{};
};

struct FrameLoopCounters {
  std::uint64_t frames = 0;   ///< used
  std::uint64_t lost = 0;     ///< gaps in the camera's numbers: superseded by newer ones, or never delivered;
                              ///< and frames with a stamp no later than that of the frame before
  std::uint64_t no_pose = 0;  ///< skipped: the pose at their exposure is not known
  std::uint64_t unusable = 0;  ///< of those used: told the map nothing (a fault, or no point measured)
  std::uint64_t late = 0;      ///< took longer than there was time
  std::uint64_t left_out = 0;  ///< not looked at, to have more time for others
  std::array<std::uint64_t, kFrameLevels> at_level{};  ///< of those used, by FrameLevel
};

/// What can be seen of one frame's work; the references hold during the observer's call only.
struct FrameSnapshot {
  const FrameStamp& stamp;
  const vision::RangeView& view;
  const hal::GrayImage* picture;
  const Eigen::Isometry3d& map_from_view;
  const Eigen::Isometry3d& map_from_chest;
  const Mapper& mapper;
  const Mission& mission;
  const BusReport& bus;  ///< as the mission was told: its stance in the map frame
  const MotionOrder& order;
  const nav::IntegrationStats& integration;
  const StageTimes& times;
};
using FrameObserver = std::function<void(const FrameSnapshot&)>;

class FrameLoop {
 public:
  /// `stopwatch` measures the stages; it need not be the clock that the loop runs by.
  FrameLoop(const FrameLoopConfig& config, Eyes& eyes, Mapper& mapper, Mission& mission, Links& links,
            const hal::Clock& stopwatch);

  /// The robot is set up in a map that is known from before; ahead of the first frame. Throws as
  /// Mapper::restore.
  void restore(const nav::SavedMap& known);

  void observe(FrameObserver observer) { observer_ = std::move(observer); }
  /// All that work() takes in from now on is shown to `intake`, which must outlive this.
  void show(IntakeObserver& intake) { intake_ = &intake; }

  /// Works on the newest frame whose pose is known. True when there is an order to publish: of a frame, or
  /// for want of frames.
  bool work(Time now);
  /// In simulation: the last work() is to take as long as these stages do at full effort, whatever was
  /// measured. How long that is.
  Duration charge(const StageTimes& full);
  /// Hands the order of the last work() to the bus loop.
  void publish();
  /// Hands over that nothing more is to be walked; the head stays as it was told last.
  void rest();

  const FrameLoopCounters& counters() const { return counters_; }
  const StageTimes& times() const { return times_; }
  FrameLevel level() const { return budget_.level(); }
  /// As FrameBudget::fix().
  void fix_level(FrameLevel level) { budget_.fix(level); }
  const Localisation& localisation() const { return localisation_; }
  const nav::Levelling& levelling() const { return levelling_; }

 private:
  struct Pose {
    Eigen::Isometry3d odom_from_chest;
    hal::HeadAngles head;
  };
  bool decide(Time now);
  void take_samples();
  void take_goals();
  void take_looks();
  void take_frame();
  void account();
  bool miss_frames(Time now);
  std::optional<Pose> pose_at(Time t) const;
  BusReport report_in_map() const;
  void glance(Time now, const BusReport& bus);
  void use(Time now, const Pose& pose);

  FrameLoopConfig config_;
  Eyes& eyes_;
  Mapper& mapper_;
  Mission& mission_;
  Links& links_;
  const hal::Clock& stopwatch_;
  FrameObserver observer_;
  IntakeObserver* intake_ = nullptr;
  nav::Levelling levelling_;
  Localisation localisation_;
  Glance glance_;
  hal::ChestHistory chest_;
  hal::HeadHistory head_;
  std::optional<FrameStamp> waiting_;     ///< taken, its pose not known yet
  std::optional<FrameStamp> last_taken_;  ///< as the camera stamped it
  FrameBudget budget_;
  std::optional<Duration> took_;  ///< the last work(), while it is not accounted for
  Time last_look_ = nav::kNever;  ///< exposure of the newest frame that told the map something
  std::optional<Time> last_work_;
  // Of the newest frame that was worked on:
  std::optional<Time> last_exposure_;
  hal::HeadAngles last_head_;
  Eigen::Isometry3d last_chest_ = Eigen::Isometry3d::Identity();  ///< in the map
  MotionOrder order_;
  StageTimes times_;
  FrameLoopCounters counters_;
};

}  // namespace headway::runtime
