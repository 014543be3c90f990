#include "runtime/bus_loop.h"

#include "hal/step_number.h"

namespace headway::runtime {

namespace {
constexpr std::uint8_t kFirstSession = 1;  // 0 means none on the wire
using hal::kLastSession;
}  // namespace

BusLoop::BusLoop(const BusLoopConfig& config, hal::CanBus& bus, hal::Head& head, hal::Walker& walker,
                 Links& links)
    : config_(config),
      bus_(bus),
      head_(head),
      walker_(walker),
      links_(links),
      stack_(config.steps),
      session_(kFirstSession) {
  stack_.begin(session_, config.stance);
}

void BusLoop::cycle(Time now) noexcept {
  count_cycle(now);
  receive();
  take_samples();
  take_order();
  commit_steps(now);
  record_steps();
  request_walk(now);
  head_.tick(now);
  walker_.tick(now);
  report(now);
}

void BusLoop::count_cycle(Time now) noexcept {
  if (counters_.cycles > 0) {
    const auto periods = (now - last_cycle_ + config_.period / 2) / config_.period;
    if (periods > 1) counters_.missed += static_cast<std::uint64_t>(periods - 1);
  }
  ++counters_.cycles;
  last_cycle_ = now;
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

void BusLoop::take_order() noexcept {
  if (!links_.order.update()) return;
  const MotionOrder& order = links_.order.value();
  head_.command(order.look);
  if (order.walk == MotionOrder::Walk::kPlan) take_plan(order.plan);
  if (order.walk == MotionOrder::Walk::kStop && (stack_.walking() || planned_)) stack_.stop();
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
  if (stack_.committed().at_rest && status.session != session_) return;
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
  links_.report.publish(report);
  if (observer_) observer_->reported(report);
}

}  // namespace headway::runtime
