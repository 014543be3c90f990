// What the operator's page asks of the robot: ways that are shown before they are walked, rests that keep the
// goal, lists of goals, places to explore. Everything but see() in the main loop's thread.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/live_session.h"
#include "app/report.h"
#include "hal/exchange.h"
#include "nav/next_view.h"
#include "operator/messages.h"
#include "runtime/operator_line.h"
#include "runtime/recorder.h"
#include "runtime/way_finder.h"

namespace headway::app {

class OperatorDesk {
 public:
  static constexpr Duration kPlanHolds = seconds(60);  ///< a way that was shown may be confirmed for so long

  /// The line must outlive it. `home`: where the robot began.
  OperatorDesk(const Robot& robot, const nav::FloorGrid& grid, const Pose2& home,
               runtime::OperatorLine& line);

  /// In the frame loop's thread.
  void see(const runtime::FrameSnapshot& snapshot);

  /// Does what a client asks, and answers {"ok": true, ...} or {"ok": false, "error": "..."}. `body` is a
  /// JSON object. Never throws.
  std::string answer(std::uint64_t client, std::string_view service, const std::string& body,
                     const LiveStatus& status, Time now);
  /// Once in a while: goes on with a list of goals.
  void attend(const LiveStatus& status, Time now);

  void fill(remote::OperatorStatus& out, const LiveStatus& status) const;
  /// Called with each way that is shown, and with none when it is over.
  void on_preview(std::function<void(const std::vector<Pose2>&)> show) { show_ = std::move(show); }
  /// Begins or ends a recording in the folder; throws where it cannot. Without it there is none.
  void on_record(std::string folder, std::function<void(bool)> record) {
    record_folder_ = std::move(folder);
    record_ = std::move(record);
  }
  /// How it is now.
  void recording(const runtime::RecordingState& state) { recording_ = state; }

 private:
  /// What the planner needs to know.
  struct Ground {
    nav::FloorMap floor;
    nav::Committed committed;
    hal::HeadAngles head;
    Eigen::Isometry3d map_from_chest = Eigen::Isometry3d::Identity();
    std::shared_ptr<const nav::VoxelMap> voxels;  ///< as of when the robot came to rest last; null before
    bool known = false;
  };
  struct Plan {
    std::uint32_t id = 0;
    Time made{};
    std::deque<nav::Goal> goals;
    std::optional<hal::HeadAngles> look;  ///< in place of goals
    bool explores = false;
  };
  using Service = Json (OperatorDesk::*)(std::uint64_t, const Json&, const LiveStatus&, Time);
  static const std::map<std::string_view, Service>& services();

  void stop();
  Json lease(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json plan_preview(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json forget_plan(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json plan_confirm(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json pause(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json resume(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json look(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json look_around(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json explore_preview(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json go_home(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json tour(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json record(std::uint64_t, const Json&, const LiveStatus&, Time);
  Json reset(std::uint64_t, const Json&, const LiveStatus&, Time);

  const Ground& ground();
  runtime::Way way_to(const nav::Goal& goal);
  void send(const nav::Goal& goal, Time now);
  void require_in_use(const nav::Goal& goal) const;
  /// The way to the first of the goals as it is shown, under a number by which it may be confirmed.
  Json show_plan(std::uint64_t client, std::deque<nav::Goal> goals, Time now);
  Json show_look(std::uint64_t client, const nav::NextLook& look, Time now);
  Json keep_plan(std::uint64_t client, Plan plan, const runtime::Way& way, Time now);
  void forget_intentions();

  nav::FloorGrid grid_;
  Pose2 home_;
  hal::HeadLimits head_;
  runtime::OperatorLine& line_;
  runtime::WayFinder ways_;
  nav::NextView next_view_;
  nav::Planner planner_;  ///< for the next view alone
  nav::GaitLimits gait_;
  // The frame loop's:
  Time ground_at_ = nav::kNever;
  std::uint64_t voxel_changes_ = 0;
  Ground next_ground_;
  hal::NewestSlot<Ground> ground_;
  std::map<std::uint64_t, Plan> plans_;  ///< the newest of each client
  std::uint32_t last_plan_ = 0;
  /// The newest goal that the robot was sent to.
  struct Sent {
    nav::Goal goal;
    Time at{};
    std::uint32_t stops = 0;  ///< of the robot by then: another one ends the list as well
    bool under_way = false;   ///< it was seen walking there
  };
  std::optional<Sent> sent_;
  std::deque<nav::Goal> tour_;  ///< goals still to come
  std::optional<nav::Goal> paused_;
  bool pause_seen_ = false;     ///< it no longer walks
  std::uint32_t released_ = 0;  ///< times that control was given up
  bool exploring_ = false;
  std::function<void(const std::vector<Pose2>&)> show_;
  std::function<void(bool)> record_;
  std::string record_folder_;
  runtime::RecordingState recording_;
};

}  // namespace headway::app
