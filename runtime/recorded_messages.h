// What a recording holds that ROS has no message for, in Headway's own words: package headway_msgs. Stamps
// are nanoseconds of the run's clock (int64), lengths metres, angles radians; enums travel as their numbers,
// and what may be absent as a list of none or one.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace headway::runtime::recorded {

struct Pose2 {
  static constexpr std::string_view kName = "headway_msgs/msg/Pose2";
  double x = 0, y = 0, yaw = 0;
  static void fields(auto& self, auto&& visit) {
    visit("x", self.x);
    visit("y", self.y);
    visit("yaw", self.yaw);
  }
};

struct HeadAngles {
  static constexpr std::string_view kName = "headway_msgs/msg/HeadAngles";
  double pan = 0, tilt = 0;
  static void fields(auto& self, auto&& visit) {
    visit("pan", self.pan);
    visit("tilt", self.tilt);
  }
};

/// As hal::Footstep.
struct Footstep {
  static constexpr std::string_view kName = "headway_msgs/msg/Footstep";
  std::uint8_t foot = 0;
  Pose2 landing;
  double dz = 0;
  std::int64_t duration_ns = 0;
  double clear = 0;
  static void fields(auto& self, auto&& visit) {
    visit("foot", self.foot);
    visit("landing", self.landing);
    visit("dz", self.dz);
    visit("duration_ns", self.duration_ns);
    visit("clear", self.clear);
  }
};

/// As hal::PartOfOrder.
struct PartOfOrder {
  static constexpr std::string_view kName = "headway_msgs/msg/PartOfOrder";
  std::uint8_t kind = 0;
  double x = 0, y = 0, turn = 0;
  std::uint8_t place = 0;
  static void fields(auto& self, auto&& visit) {
    visit("kind", self.kind);
    visit("x", self.x);
    visit("y", self.y);
    visit("turn", self.turn);
    visit("place", self.place);
  }
};

struct Stance {
  static constexpr std::string_view kName = "headway_msgs/msg/Stance";
  Pose2 left, right;
  static void fields(auto& self, auto&& visit) {
    visit("left", self.left);
    visit("right", self.right);
  }
};

struct CommittedStep {
  static constexpr std::string_view kName = "headway_msgs/msg/CommittedStep";
  Footstep step;
  Stance stance;
  std::vector<PartOfOrder> part;
  static void fields(auto& self, auto&& visit) {
    visit("step", self.step);
    visit("stance", self.stance);
    visit("part", self.part);
  }
};

/// As nav::Committed.
struct Committed {
  static constexpr std::string_view kName = "headway_msgs/msg/Committed";
  std::uint8_t session = 0;
  std::uint32_t next_index = 0;
  Stance stance;
  std::vector<std::uint8_t> last_foot;
  std::vector<PartOfOrder> part;
  bool stopping = false;
  std::uint8_t why = 0;
  bool at_rest = true;
  std::int64_t newest_frame_ns = 0;
  std::uint32_t taken = 0, late = 0, refused = 0;
  std::vector<CommittedStep> newest;
  static void fields(auto& self, auto&& visit) {
    visit("session", self.session);
    visit("next_index", self.next_index);
    visit("stance", self.stance);
    visit("last_foot", self.last_foot);
    visit("part", self.part);
    visit("stopping", self.stopping);
    visit("why", self.why);
    visit("at_rest", self.at_rest);
    visit("newest_frame_ns", self.newest_frame_ns);
    visit("taken", self.taken);
    visit("late", self.late);
    visit("refused", self.refused);
    visit("newest", self.newest);
  }
};

struct HeadState {
  static constexpr std::string_view kName = "headway_msgs/msg/HeadState";
  std::uint8_t health = 0;
  HeadAngles position, velocity;
  std::int64_t stamp_ns = 0;
  HeadAngles target;
  bool moving = false;
  static void fields(auto& self, auto&& visit) {
    visit("health", self.health);
    visit("position", self.position);
    visit("velocity", self.velocity);
    visit("stamp_ns", self.stamp_ns);
    visit("target", self.target);
    visit("moving", self.moving);
  }
};

/// As hal::WalkStatus.
struct WalkStatus {
  static constexpr std::string_view kName = "headway_msgs/msg/WalkStatus";
  std::uint8_t state = 0, session = 0, executing = 0, accepted = 0, rejected = 0, reject_reason = 0;
  std::int32_t queue_free = 0;
  std::int64_t phase_remaining_ns = 0, stamp_ns = 0;
  static void fields(auto& self, auto&& visit) {
    visit("state", self.state);
    visit("session", self.session);
    visit("executing", self.executing);
    visit("accepted", self.accepted);
    visit("rejected", self.rejected);
    visit("reject_reason", self.reject_reason);
    visit("queue_free", self.queue_free);
    visit("phase_remaining_ns", self.phase_remaining_ns);
    visit("stamp_ns", self.stamp_ns);
  }
};

struct ClockOffset {
  static constexpr std::string_view kName = "headway_msgs/msg/ClockOffset";
  std::int64_t offset_ns = 0, uncertainty_ns = 0;
  static void fields(auto& self, auto&& visit) {
    visit("offset_ns", self.offset_ns);
    visit("uncertainty_ns", self.uncertainty_ns);
  }
};

/// As runtime::SafetyReport, without its counts.
struct Safety {
  static constexpr std::string_view kName = "headway_msgs/msg/Safety";
  std::uint8_t state = 0, event = 0;
  std::vector<std::uint8_t> source;
  std::uint32_t stops = 0;
  std::vector<std::uint8_t> levels;  ///< by source
  static void fields(auto& self, auto&& visit) {
    visit("state", self.state);
    visit("event", self.event);
    visit("source", self.source);
    visit("stops", self.stops);
    visit("levels", self.levels);
  }
};

/// As runtime::BusReport. Those of every bus cycle leave the committed steps themselves out.
struct BusReport {
  static constexpr std::string_view kName = "headway_msgs/msg/BusReport";
  std::int64_t stamp_ns = 0;
  HeadState head;
  WalkStatus walk;
  std::uint8_t walker = 0;
  std::vector<ClockOffset> control_clock;
  Committed committed;
  std::uint8_t last_stop = 0, last_reject = 0;
  std::uint32_t last_steps = 0;
  Safety safety;
  static void fields(auto& self, auto&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("head", self.head);
    visit("walk", self.walk);
    visit("walker", self.walker);
    visit("control_clock", self.control_clock);
    visit("committed", self.committed);
    visit("last_stop", self.last_stop);
    visit("last_reject", self.last_reject);
    visit("last_steps", self.last_steps);
    visit("safety", self.safety);
  }
};

struct StepPlan {
  static constexpr std::string_view kName = "headway_msgs/msg/StepPlan";
  std::uint8_t session = 0;
  std::uint32_t first_index = 0;
  std::vector<Footstep> steps;
  std::vector<PartOfOrder> orders;  ///< one for each step, or none
  bool complete = false;
  std::int64_t newest_frame_ns = 0;
  static void fields(auto& self, auto&& visit) {
    visit("session", self.session);
    visit("first_index", self.first_index);
    visit("steps", self.steps);
    visit("orders", self.orders);
    visit("complete", self.complete);
    visit("newest_frame_ns", self.newest_frame_ns);
  }
};

/// As runtime::MotionOrder.
struct MotionOrder {
  static constexpr std::string_view kName = "headway_msgs/msg/MotionOrder";
  HeadAngles look;
  std::uint8_t walk = 0;
  StepPlan plan;
  std::int64_t seen_ns = 0;
  bool goal = false;
  std::uint32_t goal_after = 0;
  static void fields(auto& self, auto&& visit) {
    visit("look", self.look);
    visit("walk", self.walk);
    visit("plan", self.plan);
    visit("seen_ns", self.seen_ns);
    visit("goal", self.goal);
    visit("goal_after", self.goal_after);
  }
};

struct ChestSample {
  static constexpr std::string_view kName = "headway_msgs/msg/ChestSample";
  std::int64_t stamp_ns = 0;
  std::array<double, 12> odom_from_chest{};  ///< 3 x 4, column by column
  static void fields(auto& self, auto&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("odom_from_chest", self.odom_from_chest);
  }
};

struct HeadSample {
  static constexpr std::string_view kName = "headway_msgs/msg/HeadSample";
  std::int64_t stamp_ns = 0;
  HeadAngles angles;
  static void fields(auto& self, auto&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("angles", self.angles);
  }
};

/// A command: go there. It counts from the next work on.
struct Goal {
  static constexpr std::string_view kName = "headway_msgs/msg/Goal";
  double x = 0, y = 0;  ///< in the map
  std::vector<double> yaw;
  double tolerance = 0;
  bool near = false;
  static void fields(auto& self, auto&& visit) {
    visit("x", self.x);
    visit("y", self.y);
    visit("yaw", self.yaw);
    visit("tolerance", self.tolerance);
    visit("near", self.near);
  }
};

/// As runtime::GoalOrder.
struct GoalOrder {
  static constexpr std::string_view kName = "headway_msgs/msg/GoalOrder";
  Goal goal;
  std::uint32_t after = 0;
  static void fields(auto& self, auto&& visit) {
    visit("goal", self.goal);
    visit("after", self.after);
  }
};

/// As runtime::LookOrder.
struct LookOrder {
  static constexpr std::string_view kName = "headway_msgs/msg/LookOrder";
  bool around = false;
  HeadAngles head;
  static void fields(auto& self, auto&& visit) {
    visit("around", self.around);
    visit("head", self.head);
  }
};

/// One call of FrameLoop::work: all that it took in, and what came of it.
struct Work {
  static constexpr std::string_view kName = "headway_msgs/msg/Work";
  std::int64_t now_ns = 0;
  std::vector<ChestSample> chest;
  std::vector<HeadSample> head;
  std::vector<GoalOrder> goals;
  std::vector<LookOrder> looks;
  std::uint8_t level = 0;                  ///< runtime::FrameLevel
  std::vector<std::uint64_t> frame;        ///< the number of the frame that was taken from the camera
  std::vector<std::int64_t> stopwatch_ns;  ///< what its stopwatch showed, reading by reading
  std::vector<BusReport> report;           ///< that its order rests on
  std::vector<MotionOrder> order;
  std::uint32_t floor_sum = 0;  ///< CRC-32 of the floor map's cells after the order; 0 without one
  static void fields(auto& self, auto&& visit) {
    visit("now_ns", self.now_ns);
    visit("chest", self.chest);
    visit("head", self.head);
    visit("goals", self.goals);
    visit("looks", self.looks);
    visit("level", self.level);
    visit("frame", self.frame);
    visit("stopwatch_ns", self.stopwatch_ns);
    visit("report", self.report);
    visit("order", self.order);
    visit("floor_sum", self.floor_sum);
  }
};

/// As runtime::StepRecord.
struct Step {
  static constexpr std::string_view kName = "headway_msgs/msg/Step";
  std::int64_t committed_ns = 0, frame_age_ns = 0;
  std::uint8_t session = 0;
  std::uint32_t index = 0;
  Footstep step;
  std::vector<PartOfOrder> order;
  Pose2 landing;  ///< in the odometry frame
  static void fields(auto& self, auto&& visit) {
    visit("committed_ns", self.committed_ns);
    visit("frame_age_ns", self.frame_age_ns);
    visit("session", self.session);
    visit("index", self.index);
    visit("step", self.step);
    visit("order", self.order);
    visit("landing", self.landing);
  }
};

struct Mission {
  static constexpr std::string_view kName = "headway_msgs/msg/Mission";
  std::string state, reason;
  std::int32_t plans = 0, replans = 0, threats = 0, pauses = 0, look_arounds = 0;
  static void fields(auto& self, auto&& visit) {
    visit("state", self.state);
    visit("reason", self.reason);
    visit("plans", self.plans);
    visit("replans", self.replans);
    visit("threats", self.threats);
    visit("pauses", self.pauses);
    visit("look_arounds", self.look_arounds);
  }
};

/// What the recorder could not take in, counted since it began: the disk was too slow for it.
struct Drops {
  static constexpr std::string_view kName = "headway_msgs/msg/Drops";
  std::uint64_t can_frames = 0, bus_reports = 0, steps = 0, pictures = 0, rows = 0;
  static void fields(auto& self, auto&& visit) {
    visit("can_frames", self.can_frames);
    visit("bus_reports", self.bus_reports);
    visit("steps", self.steps);
    visit("pictures", self.pictures);
    visit("rows", self.rows);
  }
  bool operator==(const Drops&) const = default;
};

}  // namespace headway::runtime::recorded
