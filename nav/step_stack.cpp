#include "nav/step_stack.h"

#include <string>
#include <type_traits>

#include "hal/error.h"
#include "hal/step_number.h"

namespace headway::nav {

static_assert(std::is_trivially_copyable_v<StepPlan>);
static_assert(std::is_trivially_copyable_v<Committed>);
static_assert(std::is_trivially_copyable_v<StepStack>);

namespace {

constexpr std::int64_t kAhead = 2;  // the steps after the one under way that have to be known

const StepStackConfig& validated(const StepStackConfig& config) {
  config.validate();
  return config;
}

}  // namespace

void StepStackConfig::validate() const {
  const auto check = [](const char* name, Duration value, Duration lowest, Duration highest) {
    if (value >= lowest && value <= highest) return;
    throw InputError("steps: " + std::string(name) + ": " + std::to_string(to_seconds(value)) +
                     " s, expected " + std::to_string(to_seconds(lowest)) + " to " +
                     std::to_string(to_seconds(highest)) + " s");
  };
  check("shortest_step", shortest_step, seconds(0.1), seconds(10));
  check("known_after", known_after, Duration::zero(), shortest_step);
  check("lead", lead, Duration::zero(), seconds(2));
  check("margin", margin, Duration::zero(), seconds(1));
  // A step that waits longer than this is late by itself.
  check("commit_by", commit_by, lead + margin, seconds(5));
  check("commit_from", commit_from, commit_by, seconds(5));
  check("max_map_age", max_map_age, seconds(0.05), seconds(60));
  check("status_timeout", status_timeout, seconds(0.02), seconds(2));
  check("start_timeout", start_timeout, seconds(0.1), seconds(60));
}

StepStack::StepStack(const StepStackConfig& config) : config_(validated(config)) {}

bool StepStack::begin(std::uint8_t session, const hal::Stance& stance) noexcept {
  if (!committed_.at_rest || session > hal::kLastSession || (begun_ && session == committed_.session))
    return false;
  begun_ = true;
  has_plan_ = new_plan_ = due_ = false;
  executing_ = kNone;
  first_stance_ = stance;
  committed_.session = session;
  committed_.next_index = 0;
  committed_.stance = stance;
  committed_.last_foot.reset();
  committed_.part.reset();
  committed_.stopping = false;
  committed_.why = StackStop::kNone;
  return true;
}

PlanVerdict StepStack::check(const StepPlan& plan) const noexcept {
  if (!begun_ || plan.session != committed_.session) return PlanVerdict::kSession;
  if (committed_.stopping) return PlanVerdict::kStopping;
  if (plan.count < 0 || plan.count > StepPlan::kMost) return PlanVerdict::kInvalid;
  if (plan.first_index < committed_.next_index) return PlanVerdict::kLate;
  if (plan.first_index > committed_.next_index) return PlanVerdict::kGap;
  std::optional<hal::Foot> last = committed_.last_foot;
  for (std::size_t i = 0; i < static_cast<std::size_t>(plan.count); ++i) {
    if (last == plan.steps[i].foot) return PlanVerdict::kInvalid;
    last = plan.steps[i].foot;
  }
  return PlanVerdict::kTaken;
}

PlanVerdict StepStack::propose(const StepPlan& plan) noexcept {
  const PlanVerdict verdict = check(plan);
  if (verdict == PlanVerdict::kTaken) {
    plan_ = plan;
    has_plan_ = new_plan_ = true;
    due_ = false;
    ++committed_.taken;
  } else {
    ++(verdict == PlanVerdict::kLate ? committed_.late : committed_.refused);
  }
  return verdict;
}

void StepStack::stop(StackStop why) noexcept {
  due_ = false;
  if (committed_.stopping) return;
  committed_.stopping = true;
  committed_.why = why;
}

std::optional<std::uint32_t> StepStack::executing() const noexcept {
  if (executing_ == kNone) return std::nullopt;
  return static_cast<std::uint32_t>(executing_);
}

/// The newest committed step with this number on the wire; kNone when there is none.
std::int64_t StepStack::committed_index(std::uint8_t number) const noexcept {
  if (committed_.next_index == 0) return kNone;
  const std::optional<std::uint32_t> index = hal::unwrapped(number, committed_.next_index - 1);
  return index ? std::int64_t{*index} : kNone;
}

/// The control computer has not taken the steps from `index` on, and will not.
void StepStack::forget_from(std::int64_t index) noexcept {
  if (index >= static_cast<std::int64_t>(committed_.next_index)) return;
  committed_.next_index = static_cast<std::uint32_t>(index);
  if (index == 0) {
    committed_.stance = first_stance_;
    committed_.last_foot.reset();
    committed_.part.reset();
    return;
  }
  const CommittedStep& last = committed_.newest[static_cast<std::size_t>(index - 1) % Committed::kKept];
  committed_.stance = last.stance;
  committed_.last_foot = last.step.foot;
  committed_.part = last.part;
}

void StepStack::come_to_rest() noexcept {
  if (executing_ + 1 < static_cast<std::int64_t>(committed_.next_index) || !plan_ends())
    stop(StackStop::kEnded);
  committed_.stopping = true;
  forget_from(executing_ + 1);
  committed_.last_foot.reset();
  committed_.at_rest = true;
  due_ = false;
}

void StepStack::follow_session(const hal::WalkStatus& status) noexcept {
  const std::int64_t executing = committed_index(status.executing);
  if (executing < executing_) return stop(StackStop::kLost);
  executing_ = executing;
  const std::int64_t accepted = committed_index(status.accepted), rejected = committed_index(status.rejected);
  const bool refused = status.reject_reason != hal::StepReject::kNone &&
                       status.reject_reason != hal::StepReject::kFull;  // a full queue passes
  if (refused && rejected > accepted) {
    stop(StackStop::kRejected);
    forget_from(rejected);
  }
  // A step that was not there at its deadline is refused from then on.
  if (executing_ != kNone && accepted + 1 < static_cast<std::int64_t>(committed_.next_index) &&
      until_deadline(static_cast<std::uint32_t>(accepted + 1), status.stamp, status) < Duration::zero()) {
    stop(StackStop::kEnded);
    forget_from(accepted + 1);
  }
  if (executing_ != kNone && status.state == hal::WalkState::kStanding) come_to_rest();
}

/// Steps were sent and the robot still stands: wait, then give it up and count them as never sent.
void StepStack::give_up_start(Time now, const hal::WalkStatus& status) noexcept {
  if (executing_ != kNone || now - first_sent_ <= config_.start_timeout) return;
  stop(StackStop::kNoStart);
  if (status.state == hal::WalkState::kStanding) come_to_rest();
}

void StepStack::follow(Time now, const hal::WalkStatus& status) noexcept {
  if (committed_.at_rest) return;
  if (now - status.stamp > config_.status_timeout) return stop(StackStop::kLost);
  if (status.state == hal::WalkState::kFault) stop(StackStop::kLost);
  if (status.session == committed_.session) {
    follow_session(status);
  } else if (executing_ != kNone) {
    stop(StackStop::kRestarted);
    committed_.why = StackStop::kRestarted;  // whatever it was stopped for before
    if (status.state == hal::WalkState::kStanding) come_to_rest();
  }
  if (!committed_.at_rest) give_up_start(now, status);
}

const hal::Footstep* StepStack::next_step() const noexcept {
  if (!has_plan_) return nullptr;
  const std::uint32_t place = committed_.next_index - plan_.first_index;
  return place < static_cast<std::uint32_t>(plan_.count) ? &plan_.steps[place] : nullptr;
}

/// The order that the next step is part of.
std::optional<hal::PartOfOrder> StepStack::next_part() const noexcept {
  if (next_step() == nullptr || !plan_.in_orders) return std::nullopt;
  return plan_.orders[committed_.next_index - plan_.first_index];
}

bool StepStack::plan_ends() const noexcept { return has_plan_ && plan_.complete && next_step() == nullptr; }

/// The next step can no longer be sent in time.
void StepStack::pass_deadline(Time now) noexcept {
  if (plan_ends()) {
    stop(StackStop::kNone);
  } else {
    stop(next_step() != nullptr && !fresh(now) ? StackStop::kStale : StackStop::kMissed);
  }
}

/// Of step `index`, not the first one, while one is under way. Nothing is known of the steps after the next
/// lift-off: their deadlines lie after it.
Duration StepStack::until_deadline(std::uint32_t index, Time now,
                                   const hal::WalkStatus& status) const noexcept {
  const auto under_way = static_cast<std::uint32_t>(executing_);
  Duration until = status.phase_remaining - (now - status.stamp) + config_.known_after;  // of under_way + 3
  if (index > under_way + kAhead) return until;
  until -= committed_.newest[under_way % Committed::kKept].step.duration;
  return until - config_.shortest_step * (under_way + kAhead - index);
}

bool StepStack::may_commit(Time now, const hal::WalkStatus& status) noexcept {
  const auto next = static_cast<std::int64_t>(committed_.next_index);
  if (executing_ == kNone) return next == 0 && status.state == hal::WalkState::kStanding;
  if (next > executing_ + kAhead + 1) return false;
  const Duration remaining = until_deadline(committed_.next_index, now, status);
  if (remaining < config_.lead + config_.margin) {
    pass_deadline(now);
    return false;
  }
  if (remaining > config_.commit_from) {
    new_plan_ = false;
    return false;
  }
  return new_plan_ || remaining <= config_.commit_by;
}

std::optional<hal::NumberedStep> StepStack::due(Time now, const hal::WalkStatus& status) noexcept {
  due_ = false;
  follow(now, status);
  if (!begun_ || committed_.stopping || now - status.stamp > config_.status_timeout) return std::nullopt;
  if (status.state == hal::WalkState::kFault || !may_commit(now, status)) return std::nullopt;
  const hal::Footstep* step = next_step();
  if (step == nullptr || !fresh(now)) return std::nullopt;
  due_ = true;
  return hal::NumberedStep{committed_.next_index, *step, next_part()};
}

void StepStack::sent(Time now) noexcept {
  const hal::Footstep* step = next_step();
  if (!due_ || step == nullptr) return;
  due_ = false;
  if (committed_.next_index == 0) first_sent_ = now;
  committed_.stance = committed_.stance.after(*step);
  committed_.last_foot = step->foot;
  committed_.part = next_part();
  committed_.newest_frame = plan_.newest_frame;
  committed_.at_rest = false;
  committed_.newest[committed_.next_index % Committed::kKept] = {*step, committed_.stance, committed_.part};
  ++committed_.next_index;
}

}  // namespace headway::nav
