#include "runtime/frame_loop.h"

#include <limits>
#include <utility>

namespace headway::runtime {
namespace {
constexpr int kStepsSure = 4;                                       // while the head looks elsewhere
constexpr double kAsFar = std::numeric_limits<double>::infinity();  // as the cameras are trusted [m]
}  // namespace

FrameLoop::FrameLoop(const FrameLoopConfig& config, Eyes& eyes, Mapper& mapper, Mission& mission,
                     Links& links, const hal::Clock& stopwatch)
    : config_(config),
      eyes_(eyes),
      mapper_(mapper),
      mission_(mission),
      links_(links),
      stopwatch_(stopwatch),
      levelling_(config.levelling),
      localisation_(config.localisation, mapper.voxels()),
      glance_(config.localisation.glance),
      budget_(config.budget) {}

void FrameLoop::restore(const nav::SavedMap& known) {
  mapper_.restore(known.map);
  localisation_.restore(known.surfaces);
}

bool FrameLoop::work(Time now) {
  if (intake_) intake_->begins(now, level());
  const bool ordered = decide(now);
  if (intake_) intake_->ends(ordered ? &order_ : nullptr, links_.report.value(), waiting_.has_value());
  return ordered;
}

bool FrameLoop::decide(Time now) {
  take_samples();
  take_goals();
  take_looks();
  take_frame();
  if (!waiting_) return miss_frames(now);
  const auto pose = pose_at(waiting_->exposure);
  if (!pose) {
    if (now - waiting_->exposure > config_.pose_wait) {
      ++counters_.no_pose;
      waiting_.reset();
    }
    return miss_frames(now);
  }
  last_work_ = now;
  last_exposure_ = waiting_->exposure;
  use(now, *pose);
  waiting_.reset();
  return true;
}

/// Nothing to work on. The mission must know of it when that lasts.
bool FrameLoop::miss_frames(Time now) {
  if (!last_work_) last_work_ = now;
  if (now - *last_work_ < config_.silence) return false;
  last_work_ = now;
  order_ = mission_.update({now, last_look_, "no picture comes, or none at a time when the pose is known",
                            true, localisation_.placed(), last_head_, last_chest_, report_in_map(), mapper_});
  return true;
}

Duration FrameLoop::charge(const StageTimes& full) {
  if (!took_) return full.total();
  took_ = at_level(full, budget_.level()).total();
  return *took_;
}

void FrameLoop::publish() {
  account();
  links_.order.publish(order_);
}

/// From what the last frame took follows what is done with the next.
void FrameLoop::account() {
  if (!took_) return;
  counters_.late += budget_.took(*took_);
  took_.reset();
}

void FrameLoop::rest() {
  order_.walk = MotionOrder::Walk::kStop;
  order_.goal = false;
  order_.end = true;
  publish();
}

void FrameLoop::take_samples() {
  hal::ChestSample chest;
  while (links_.chest.pop(chest)) {
    chest_.add(chest.stamp, chest.odom_from_chest);
    if (intake_) intake_->takes(chest);
  }
  HeadSample head;
  while (links_.head.pop(head)) {
    head_.add(head.stamp, head.angles);
    if (intake_) intake_->takes(head);
  }
  links_.report.update();
}

void FrameLoop::take_goals() {
  GoalOrder order;
  while (links_.goals.pop(order)) {
    mission_.set_goal(order.goal, order.after);
    if (intake_) intake_->takes(order);
  }
}

void FrameLoop::take_looks() {
  LookOrder order;
  while (links_.looks.pop(order)) {
    mission_.look(order);
    if (intake_) intake_->takes(order);
  }
}

void FrameLoop::take_frame() {
  const auto frame = eyes_.take();
  if (!frame) return;
  if (waiting_) ++counters_.lost;  // superseded before its pose was known
  waiting_.reset();
  if (last_taken_ && frame->sequence > last_taken_->sequence + 1)
    counters_.lost += frame->sequence - last_taken_->sequence - 1;
  const bool stuck = last_taken_ && frame->exposure <= last_taken_->exposure;
  last_taken_ = frame;
  if (stuck) {  // nobody knows when it was exposed
    ++counters_.lost;
    return;
  }
  waiting_ = frame;
  waiting_->exposure += config_.camera_time_offset;
  if (last_exposure_ && budget_.leaves_out(waiting_->exposure - *last_exposure_)) {
    ++counters_.left_out;
    waiting_.reset();
  }
}

std::optional<FrameLoop::Pose> FrameLoop::pose_at(Time t) const {
  const auto chest = chest_.at(t, config_.pose_gap);
  const auto head = head_.at(t, config_.pose_gap);
  if (!chest || !head) return std::nullopt;
  return Pose{*chest, *head};
}

/// Footsteps are relative to each other, so those that are planned in the map need no conversion, and those
/// already sent stay what they are: only where the committed ones end is another place in the map.
BusReport FrameLoop::report_in_map() const {
  BusReport report = links_.report.value();
  const auto move = [&](hal::Stance& stance) {
    stance = {localisation_.steady() * stance.left, localisation_.steady() * stance.right};
  };
  move(report.committed.stance);
  for (nav::CommittedStep& committed : report.committed.newest) move(committed.stance);
  return report;
}

/// Looks up from the way now and then while the next steps are sure.
void FrameLoop::glance(Time now, const BusReport& bus) {
  const bool sure = order_.plan.complete || order_.plan.count >= kStepsSure;
  const bool walks = mission_.state() == MissionState::kWalk && !bus.committed.at_rest;
  if (walks && sure)
    order_.look = glance_.direct(order_.look, localisation_.drift().covariance(),
                                 localisation_.drift().map_from_robot().yaw, now);
  else
    glance_.end(now);
}

void FrameLoop::use(Time now, const Pose& pose) {
  const Time begin = stopwatch_.now();
  const FrameLevel level = budget_.level();
  eyes_.look_with({level >= FrameLevel::kHalfResolution, level >= FrameLevel::kNear ? config_.near : kAsFar});
  const vision::RangeView& view = eyes_.see();
  const Time seen = stopwatch_.now();
  Eigen::Isometry3d odom_from_view =
      pose.odom_from_chest * config_.neck.chest_from_camera(pose.head) * eyes_.left_from_view();
  std::string blind = eyes_.fault();
  const bool faulty = !blind.empty();
  if (!faulty) {
    odom_from_view = levelling_.level(view, odom_from_view, waiting_->exposure);
    localisation_.see(view, odom_from_view, pose.odom_from_chest, waiting_->exposure, mapper_.passing());
  }
  const Eigen::Isometry3d map_from_odom = localisation_.map_from_odom().lifted();
  const Eigen::Isometry3d map_from_view = map_from_odom * odom_from_view,
                          map_from_chest = map_from_odom * pose.odom_from_chest;
  nav::IntegrationStats integration;
  const bool placed = localisation_.placed();
  if (!faulty && placed) {
    integration = mapper_.integrate(view, map_from_view, map_from_chest, waiting_->exposure);
    localisation_.learn();
  }
  const Time mapped = stopwatch_.now();
  mapper_.project();
  const Time projected = stopwatch_.now();
  if (blind.empty() && placed && integration.samples == 0)
    blind = "no point of the picture could be measured";
  if (blind.empty())
    last_look_ = waiting_->exposure;
  else
    ++counters_.unusable;
  const BusReport bus = report_in_map();
  order_ = mission_.update(
      {now, last_look_, std::move(blind), faulty, placed, pose.head, map_from_chest, bus, mapper_});
  last_chest_ = map_from_chest;
  last_head_ = pose.head;
  glance(now, bus);
  const Time planned = stopwatch_.now();

  times_ = {seen - begin, mapped - seen, projected - mapped, planned - projected};
  took_ = times_.total();
  ++counters_.frames;
  ++counters_.at_level[static_cast<std::size_t>(level)];
  if (observer_)
    observer_({*waiting_, view, eyes_.picture(), map_from_view, map_from_chest, mapper_, mission_, bus,
               order_, integration, times_});
}

}  // namespace headway::runtime
