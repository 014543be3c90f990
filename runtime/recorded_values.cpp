#include "runtime/recorded_values.h"

#include <algorithm>
#include <type_traits>

#include <zlib.h>

namespace headway::runtime {

namespace ros = recording::ros;

namespace {

template <class Enum>
std::uint8_t number(Enum value) {
  return static_cast<std::uint8_t>(value);
}
std::int64_t number(Time t) { return t.time_since_epoch().count(); }
Time time(std::int64_t ns) { return Time(Duration(ns)); }

recorded::Pose2 put(const Pose2& p) { return {p.x, p.y, p.yaw}; }
Pose2 take(const recorded::Pose2& p) { return {p.x, p.y, p.yaw}; }

recorded::HeadAngles put(const hal::HeadAngles& a) { return {a.pan, a.tilt}; }
hal::HeadAngles take(const recorded::HeadAngles& a) { return {a.pan, a.tilt}; }

recorded::Stance put(const hal::Stance& s) { return {put(s.left), put(s.right)}; }
hal::Stance take(const recorded::Stance& s) { return {take(s.left), take(s.right)}; }

recorded::Footstep put(const hal::Footstep& s) {
  return {number(s.foot), put(s.landing), s.dz, s.duration.count(), s.clear};
}
hal::Footstep take(const recorded::Footstep& s) {
  return {hal::Foot{s.foot}, take(s.landing), s.dz, Duration(s.duration_ns), s.clear};
}

recorded::PartOfOrder put(const hal::PartOfOrder& p) {
  return {number(p.order.kind), p.order.x, p.order.y, p.order.turn, p.place};
}
hal::PartOfOrder take(const recorded::PartOfOrder& p) {
  return {{hal::WalkOrder::Kind{p.kind}, p.x, p.y, p.turn}, p.place};
}

template <class Value>
auto list(const std::optional<Value>& value) {
  std::vector<decltype(put(*value))> some;
  if (value) some.push_back(put(*value));
  return some;
}
std::optional<hal::PartOfOrder> first(const std::vector<recorded::PartOfOrder>& some) {
  if (some.empty()) return std::nullopt;
  return take(some.front());
}

recorded::Committed put(const nav::Committed& c, bool with_steps) {
  recorded::Committed out{.session = c.session,
                          .next_index = c.next_index,
                          .stance = put(c.stance),
                          .last_foot = {},
                          .part = list(c.part),
                          .stopping = c.stopping,
                          .why = number(c.why),
                          .at_rest = c.at_rest,
                          .newest_frame_ns = number(c.newest_frame),
                          .taken = c.taken,
                          .late = c.late,
                          .refused = c.refused,
                          .newest = {}};
  if (c.last_foot) out.last_foot.push_back(number(*c.last_foot));
  if (with_steps)
    for (const nav::CommittedStep& step : c.newest)
      out.newest.push_back({put(step.step), put(step.stance), list(step.part)});
  return out;
}

nav::Committed take(const recorded::Committed& c) {
  nav::Committed out;
  out.session = c.session;
  out.next_index = c.next_index;
  out.stance = take(c.stance);
  if (!c.last_foot.empty()) out.last_foot = hal::Foot{c.last_foot.front()};
  out.part = first(c.part);
  out.stopping = c.stopping;
  out.why = nav::StackStop{c.why};
  out.at_rest = c.at_rest;
  out.newest_frame = time(c.newest_frame_ns);
  out.taken = c.taken;
  out.late = c.late;
  out.refused = c.refused;
  for (std::size_t i = 0; i < std::min(out.newest.size(), c.newest.size()); ++i)
    out.newest[i] = {take(c.newest[i].step), take(c.newest[i].stance), first(c.newest[i].part)};
  return out;
}

recorded::HeadState put(const hal::HeadState& h) {
  return {number(h.health), put(h.position), put(h.velocity), number(h.stamp), put(h.target), h.moving};
}
hal::HeadState take(const recorded::HeadState& h) {
  return {hal::HeadHealth{h.health}, take(h.position), take(h.velocity),
          time(h.stamp_ns),          take(h.target),   h.moving};
}

recorded::WalkStatus put(const hal::WalkStatus& w) {
  return {number(w.state), w.session,
          w.executing,     w.accepted,
          w.rejected,      number(w.reject_reason),
          w.queue_free,    w.phase_remaining.count(),
          number(w.stamp)};
}
hal::WalkStatus take(const recorded::WalkStatus& w) {
  return {hal::WalkState{w.state},
          w.session,
          w.executing,
          w.accepted,
          w.rejected,
          hal::StepReject{w.reject_reason},
          w.queue_free,
          Duration(w.phase_remaining_ns),
          time(w.stamp_ns)};
}

recorded::Safety put(const SafetyReport& s) {
  recorded::Safety out{number(s.state), number(s.event), {}, s.stops, {}};
  if (s.source) out.source.push_back(number(*s.source));
  for (const SafetyReport::Watch& watch : s.sources) out.levels.push_back(number(watch.level));
  return out;
}
SafetyReport take(const recorded::Safety& s) {
  SafetyReport out;
  out.state = SafetyState{s.state};
  out.event = SafetyEvent{s.event};
  // What names one that is none, as no program of ours writes, names none.
  if (!s.source.empty() && s.source.front() < kSources) out.source = SafetySource{s.source.front()};
  out.stops = s.stops;
  for (std::size_t i = 0; i < std::min(kSources, s.levels.size()); ++i)
    out.sources[i].level = SourceLevel{s.levels[i]};
  return out;
}

}  // namespace

recorded::BusReport to_recorded(const BusReport& r, bool with_steps) {
  recorded::BusReport out{.stamp_ns = number(r.stamp),
                          .head = put(r.head),
                          .walk = put(r.walk),
                          .walker = number(r.walker),
                          .control_clock = {},
                          .committed = put(r.committed, with_steps),
                          .last_stop = number(r.last_stop),
                          .last_reject = number(r.last_reject),
                          .last_steps = r.last_steps,
                          .safety = put(r.safety)};
  if (r.control_clock)
    out.control_clock.push_back({r.control_clock->offset.count(), r.control_clock->uncertainty.count()});
  return out;
}

BusReport from_recorded(const recorded::BusReport& r) {
  BusReport out;
  out.stamp = time(r.stamp_ns);
  out.head = take(r.head);
  out.walk = take(r.walk);
  out.walker = hal::WalkerHealth{r.walker};
  if (!r.control_clock.empty())
    out.control_clock = hal::ClockOffset{Duration(r.control_clock.front().offset_ns),
                                         Duration(r.control_clock.front().uncertainty_ns)};
  out.committed = take(r.committed);
  out.last_stop = nav::StackStop{r.last_stop};
  out.last_reject = hal::StepReject{r.last_reject};
  out.last_steps = r.last_steps;
  out.safety = take(r.safety);
  return out;
}

recorded::MotionOrder to_recorded(const MotionOrder& order) {
  const nav::StepPlan& plan = order.plan;
  recorded::MotionOrder out{put(order.look),    number(order.walk), {},
                            number(order.seen), order.goal,         order.goal_after};
  out.plan = {plan.session, plan.first_index, {}, {}, plan.complete, number(plan.newest_frame)};
  const auto count = static_cast<std::size_t>(std::clamp(plan.count, 0, nav::StepPlan::kMost));
  for (std::size_t i = 0; i < count; ++i) out.plan.steps.push_back(put(plan.steps[i]));
  for (std::size_t i = 0; plan.in_orders && i < count; ++i) out.plan.orders.push_back(put(plan.orders[i]));
  return out;
}

recorded::Step to_recorded(const StepRecord& s) {
  return {number(s.committed), s.frame_age.count(), s.session,     s.step.index,
          put(s.step.step),    list(s.step.order),  put(s.landing)};
}

recorded::ChestSample to_recorded(const hal::ChestSample& s) {
  recorded::ChestSample out{number(s.stamp), {}};
  Eigen::Map<Eigen::Matrix<double, 3, 4>>(out.odom_from_chest.data()) = s.odom_from_chest.affine();
  return out;
}

hal::ChestSample from_recorded(const recorded::ChestSample& s) {
  hal::ChestSample out;
  out.stamp = time(s.stamp_ns);
  out.odom_from_chest.affine() = Eigen::Map<const Eigen::Matrix<double, 3, 4>>(s.odom_from_chest.data());
  return out;
}

recorded::HeadSample to_recorded(const HeadSample& s) { return {number(s.stamp), put(s.angles)}; }
HeadSample from_recorded(const recorded::HeadSample& s) { return {time(s.stamp_ns), take(s.angles)}; }

recorded::GoalOrder to_recorded(const GoalOrder& order) { return {to_recorded(order.goal), order.after}; }
GoalOrder from_recorded(const recorded::GoalOrder& order) { return {from_recorded(order.goal), order.after}; }

recorded::LookOrder to_recorded(const LookOrder& order) { return {order.around, put(order.head)}; }
LookOrder from_recorded(const recorded::LookOrder& order) { return {order.around, take(order.head)}; }

recorded::Goal to_recorded(const nav::Goal& goal) {
  recorded::Goal out{goal.position.x(), goal.position.y(), {}, goal.tolerance, goal.near};
  if (goal.yaw) out.yaw.push_back(*goal.yaw);
  return out;
}

nav::Goal from_recorded(const recorded::Goal& goal) {
  nav::Goal out;
  out.position = {goal.x, goal.y};
  if (!goal.yaw.empty()) out.yaw = goal.yaw.front();
  out.tolerance = goal.tolerance;
  out.near = goal.near;
  return out;
}

std::uint32_t sum_of(const nav::FloorMap& floor) {
  static_assert(sizeof(nav::Floor) == 1);
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(floor.cells.data()), floor.cells.size()));
}

ros::Transform transform(const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond q(pose.linear());
  return {{t.x(), t.y(), t.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

ros::PoseStamped pose_stamped(const Pose2& pose, Time stamp, const char* frame) {
  const ros::Transform t = transform(pose.lifted());
  return {{ros::stamp(stamp), frame}, {{t.translation.x, t.translation.y, t.translation.z}, t.rotation}};
}

ros::OccupancyGrid occupancy(const nav::FloorMap& floor, Time stamp) {
  ros::OccupancyGrid out;
  out.header = {ros::stamp(stamp), "map"};
  out.info.map_load_time = out.header.stamp;
  out.info.resolution = static_cast<float>(floor.grid.resolution);
  out.info.width = static_cast<std::uint32_t>(floor.grid.width);
  out.info.height = static_cast<std::uint32_t>(floor.grid.height);
  out.info.origin.position = {floor.grid.origin.x(), floor.grid.origin.y(), 0};
  out.data.reserve(floor.cells.size());
  for (const nav::Floor cell : floor.cells) {
    constexpr std::int8_t kUnknown = -1, kFree = 0, kLow = 50, kOccupied = 100;
    out.data.push_back(cell == nav::Floor::kUnseen ? kUnknown
                       : cell == nav::Floor::kFree ? kFree
                       : cell == nav::Floor::kLow  ? kLow
                                                   : kOccupied);
  }
  return out;
}

ros::CanFrame can_frame(const hal::CanFrame& frame, Time stamp) {
  ros::CanFrame out;
  out.header.stamp = ros::stamp(stamp);
  out.id = frame.id;
  out.dlc = frame.dlc;
  out.data = frame.data;
  return out;
}

}  // namespace headway::runtime
