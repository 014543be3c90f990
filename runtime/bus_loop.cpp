#include "runtime/bus_loop.h"

#include <algorithm>

#include "hal/step_number.h"

namespace headway::runtime {

namespace {
constexpr std::uint8_t kFirstSession = 1;  // 0 means none on the wire
using hal::kLastSession;

/// No step commits on an older map, nor without a status.
WatchdogTable watchdogs_for(const nav::StepStackConfig& steps) {
  WatchdogTable table = kWatchdogs;
  WatchdogLimits& map = table[static_cast<std::size_t>(SafetySource::kMap)];
  map.poor = steps.max_map_age;
  map.lost = std::max(map.lost, 2 * map.poor);
  WatchdogLimits& control = table[static_cast<std::size_t>(SafetySource::kControl)];
  control.poor = control.lost = steps.status_timeout;
  return table;
}
}  // namespace

BusLoop::BusLoop(const BusLoopConfig& config, hal::CanBus& bus, hal::Head& head, hal::Walker& walker,
                 Links& links)
    : bus_(bus),
      head_(head),
      walker_(walker),
      links_(links),
      stack_(config.steps),
      watchdogs_(watchdogs_for(config.steps)),
      session_(kFirstSession) {
  stack_.begin(session_, config.stance);
}

void BusLoop::cycle(Time now, CycleHealth health) noexcept {
  ++counters_.cycles;
  receive();
  take_samples();
  new_order_ = links_.order.update();
  watch(now, health);
  take_order();
  commit_steps(now);
  record_steps();
  request_walk(now);
  head_.tick(now);
  walker_.tick(now);
  report(now);
}

bool BusLoop::stands() const noexcept {
  const hal::WalkerHealth health = walker_.health();
  const bool heard = health == hal::WalkerHealth::kReady || health == hal::WalkerHealth::kNoChest;
  return stack_.committed().at_rest && heard && walker_.status().state == hal::WalkState::kStanding;
}

void BusLoop::receive() noexcept {
  std::array<hal::CanFrame, 32> frames;
  std::size_t count = 0;
  while ((count = bus_.receive(frames)) > 0) {
    counters_.frames += count;
    for (std::size_t i = 0; i < count; ++i) {
      head_.receive(frames[i]);
      walker_.receive(frames[i]);
    }
  }
}

void BusLoop::take_samples() noexcept {
  const hal::ChestSample chest = walker_.chest();
  if (chest.stamp > last_chest_) {
    last_chest_ = chest.stamp;
    links_.chest.push(chest);
  }
  const hal::HeadState head = head_.state();
  if (head.stamp > last_head_) {
    last_head_ = head.stamp;
    links_.head.push({head.stamp, head.position});
  }
}

void BusLoop::hear_devices(Time now) noexcept {
  const auto say = [&](SafetySource source, bool is, SourceLevel otherwise) {
    watchdogs_.say(source, is ? SourceLevel::kFine : otherwise);
  };
  const hal::CanBusState bus = bus_.state();
  say(SafetySource::kBus, bus == hal::CanBusState::kErrorActive || bus == hal::CanBusState::kErrorWarning,
      bus == hal::CanBusState::kErrorPassive ? SourceLevel::kPoor : SourceLevel::kLost);
  const hal::HeadState head = head_.state();
  drives_began_ = drives_began_ || head.health != hal::HeadHealth::kStarting;
  if (drives_began_)
    say(SafetySource::kDrives, head.health == hal::HeadHealth::kReady,
        head.health == hal::HeadHealth::kDegraded ? SourceLevel::kPoor : SourceLevel::kLost);
  if (walker_.health() != hal::WalkerHealth::kStarting)
    watchdogs_.hear(SafetySource::kControl, walker_.status().stamp);
  // It was silent, makes no sense, or knows nothing of this walk any more.
  const nav::StackStop why = stack_.committed().why;
  say(SafetySource::kControl, why != nav::StackStop::kLost && why != nav::StackStop::kRestarted,
      SourceLevel::kLost);
  if (walker_.clock() || watchdogs_.level(SafetySource::kTime) != SourceLevel::kUnused)
    say(SafetySource::kTime, walker_.clock().has_value(), SourceLevel::kLost);
  if (last_chest_ != Time{} && last_head_ != Time{})
    watchdogs_.hear(SafetySource::kPose, std::min(last_chest_, last_head_));
  lease_.follow(links_.operator_word.value(), now);
  if (const auto renewed = lease_.renewed()) watchdogs_.hear(SafetySource::kOperator, *renewed);
}

void BusLoop::hear_order() noexcept {
  const MotionOrder& order = links_.order.value();
  if (order.seen != Time{}) watchdogs_.hear(SafetySource::kPictures, order.seen);
  if (order.plan.newest_frame > Time{}) watchdogs_.hear(SafetySource::kMap, order.plan.newest_frame);
}

SafetyInput BusLoop::safety_input() noexcept {
  const MotionOrder& order = links_.order.value();
  const OperatorWord& word = links_.operator_word.value();
  SafetyInput input;
  input.reset = word.resets != resets_heard_;
  input.stop_asked = word.stops != stops_heard_;
  input.ends = order.end || resting_;
  input.fault = walker_.status().state == hal::WalkState::kFault;
  input.goal = order.goal;
  input.goal_after = order.goal_after;
  resets_heard_ = word.resets;
  stops_heard_ = word.stops;
  return input;
}

/// What the robot may do in this cycle.
void BusLoop::watch(Time now, CycleHealth health) noexcept {
  links_.operator_word.update();
  hear_devices(now);
  hear_order();
  watchdogs_.say(SafetySource::kCycles, health == CycleHealth::kOnTime ? SourceLevel::kFine
                                        : health == CycleHealth::kLate ? SourceLevel::kPoor
                                                                       : SourceLevel::kLost);
  watchdogs_.look(now);
  const SafetyState before = safety_.state();
  const SafetyInput input = safety_input();
  if (input.reset) head_.recover();
  safety_.cycle(input, watchdogs_);
  if (safety_.state() != before) links_.safety.push({now, safety_.report()});
  if (!may_walk(safety_.state()) && (stack_.walking() || planned_)) stack_.stop();
}

void BusLoop::take_order() noexcept {
  const MotionOrder& order = links_.order.value();
  if (new_order_) {
    head_.command(order.look);
    if (order.walk == MotionOrder::Walk::kStop && (stack_.walking() || planned_)) stack_.stop();
    plan_waits_ = order.walk == MotionOrder::Walk::kPlan;
  }
  if (!plan_waits_ || !may_walk(safety_.state())) return;
  plan_waits_ = false;
  take_plan(order.plan);
}

void BusLoop::take_plan(const nav::StepPlan& plan) noexcept {
  switch (stack_.propose(plan)) {
    case nav::PlanVerdict::kTaken:
      ++counters_.plans_taken;
      planned_ = plan.count > 0;
      break;
    case nav::PlanVerdict::kLate:
    case nav::PlanVerdict::kStopping:  // the walk's last step was committed while the plan was made
      ++counters_.plans_late;
      break;
    default:
      ++counters_.plans_refused;
      break;
  }
}

void BusLoop::commit_steps(Time now) noexcept {
  const hal::WalkStatus status = walker_.status();
  const nav::Committed& committed = stack_.committed();
  if (committed.at_rest && (committed.next_index > 0 || committed.stopping)) open_next_session();
  // The control computer may still be in the session of another run of this program.
  if (!heard_ && walker_.health() != hal::WalkerHealth::kStarting) {
    heard_ = true;
    if (status.session == session_) open_next_session();
  }
  // The control computer must have taken up the session before its first step, else it refuses that step.
  if (stack_.committed().at_rest && (status.session != session_ || !may_begin_to_walk(safety_.state())))
    return;
  while (const auto step = stack_.due(now, status)) {
    if (!walker_.send(session_, *step)) return;
    stack_.sent(now);
    handed_over_[step->index % handed_over_.size()] = {now, now - stack_.committed().newest_frame, session_,
                                                       *step, stack_.committed().stance.at(step->step.foot)};
  }
}

/// A step that is handed over may yet be refused; one that has begun is walked.
void BusLoop::record_steps() noexcept {
  const auto under_way = stack_.executing();
  while (under_way && recorded_ <= *under_way) {
    const StepRecord& step = handed_over_[recorded_++ % handed_over_.size()];
    links_.steps.push(step);
    if (observer_) observer_->walked(step);
  }
}

void BusLoop::open_next_session() noexcept {
  last_stop_ = stack_.committed().why;
  last_reject_ = walker_.status().reject_reason;
  last_steps_ = recorded_;
  if (last_stop_ != nav::StackStop::kNone) ++counters_.stops;
  const hal::Stance stance = stack_.committed().stance;
  session_ = session_ == kLastSession ? kFirstSession : static_cast<std::uint8_t>(session_ + 1);
  stack_.begin(session_, stance);
  planned_ = false;
  recorded_ = 0;
}

void BusLoop::request_walk(Time now) noexcept {
  const nav::Committed& committed = stack_.committed();
  const MotionOrder& order = links_.order.value();
  hal::WalkRequest request = hal::WalkRequest::kNone;
  if (committed.stopping)
    request = hal::WalkRequest::kSmoothStop;
  else if (stack_.walking() || planned_)
    request = hal::WalkRequest::kWalk;
  walker_.control(request, session_, now - order.plan.newest_frame);
}

void BusLoop::report(Time now) noexcept {
  BusReport report;
  report.stamp = now;
  report.head = head_.state();
  report.walk = walker_.status();
  report.walker = walker_.health();
  report.control_clock = walker_.clock();
  report.committed = stack_.committed();
  report.last_stop = last_stop_;
  report.last_reject = last_reject_;
  report.last_steps = last_steps_;
  report.safety = safety_.report();
  links_.report.publish(report);
  links_.safety_now.publish(report.safety);
  if (observer_) observer_->reported(report);
}

}  // namespace headway::runtime
