#include "runtime/mission.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "hal/on_floor.h"
#include "nav/low_ahead.h"

namespace headway::runtime {

namespace {

constexpr std::size_t kStepsToStart = 3;  // a walk that begins with fewer would stop again at once
constexpr std::uint32_t kStepsAhead = 3;  // the newest committed ones, which may not have begun

std::string at(const char* text, const Eigen::Vector2d& p) {
  char line[160];
  std::snprintf(line, sizeof line, "%s (%.2f, %.2f)", text, p.x(), p.y());
  return line;
}

std::optional<Eigen::Vector2d> middle_of(const std::vector<Eigen::Vector2i>& cells,
                                         const nav::FloorGrid& grid) {
  if (cells.empty()) return std::nullopt;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& cell : cells) sum += grid.centre(cell);
  return sum / static_cast<double>(cells.size());
}

}  // namespace

const char* name(MissionState state) {
  switch (state) {
    case MissionState::kStarting:
      return "starting";
    case MissionState::kLookAround:
      return "look around";
    case MissionState::kWaitGoal:
      return "wait for a goal";
    case MissionState::kWalk:
      return "walk";
    case MissionState::kLookAhead:
      return "look ahead";
    case MissionState::kArrived:
      return "arrived";
    case MissionState::kStopped:
      return "stopped";
  }
  return "?";
}

Mission::Mission(const MissionConfig& config, const nav::FloorGrid& grid)
    : config_(config),
      ways_(config.planner, config.gait, config.outline, config.execution, grid),
      gate_(config.gate, config.gait, config.outline),
      forecaster_(nav::walking_config(config.gait), config.gait.sole_length, config.gait.sole_width),
      refusals_(config.attempts),
      second_look_(grid, 2 * config.attempts) {
  if (config.next_view)
    next_view_.emplace(nav::Viewer{config.field, config.neck, config.head}, grid.resolution,
                       *config.next_view);
}

void Mission::set_goal(const nav::Goal& goal) { set_goal(goal, stops_); }

void Mission::set_goal(const nav::Goal& goal, std::uint32_t after) {
  const bool again = over();
  goal_ = goal;
  goal_after_ = after;
  reason_.clear();
  walk_.reset();
  planned_once_ = false;
  fruitless_ = 0;
  second_look_.forget();
  sight_.reset();
  turned_.reset();
  refusals_.forget();
  if (again) begin_look_around();
}

void Mission::look(const LookOrder& order) {
  if (state_ != MissionState::kWaitGoal && !over()) return;
  goal_.reset();  // what was arrived at or given up is not walked to again after the look
  reason_.clear();
  state_ = MissionState::kWaitGoal;
  look_ = limited(order.head, config_.head);
  if (order.around) begin_look_around();
}

MotionOrder Mission::update(const MissionInput& input) {
  stops_ = input.bus.safety.stops;
  if (!input.faulty) seen_ = input.now;
  MotionOrder order = decide(input);
  order.seen = seen_;
  order.goal = goal_ && !over();
  order.goal_after = goal_after_;
  return order;
}

MotionOrder Mission::decide(const MissionInput& input) {
  second_look_.follow(input.mapper);
  auto reason = hopeless(input);
  if (reason && goal_ && !over() && state_ != MissionState::kStarting) give_up(*std::move(reason));
  switch (state_) {
    case MissionState::kStarting:
      return starting(input);
    case MissionState::kLookAround:
      return look_around(input);
    case MissionState::kWalk:
      if (!input.placed) state_ = MissionState::kLookAround;
      return input.placed ? walk_on(input) : rest(input);
    case MissionState::kLookAhead:
      return look_ahead(input);
    case MissionState::kWaitGoal:
      if (goal_) state_ = MissionState::kWalk;
      return rest(input);
    case MissionState::kArrived:
    case MissionState::kStopped:
      return rest(input);
  }
  return rest(input);
}

/// Why the goal must be given up, whatever the map says.
std::optional<std::string> Mission::hopeless(const MissionInput& input) {
  auto blind = blind_too_long(input);
  if (input.bus.walk.state == hal::WalkState::kFault) return "the control computer reports a fault";
  if (auto refused = refusals_.look(input.bus)) return refused;
  if (goal_after_ != stops_)
    return "stopped for safety: " + describe(input.bus.safety) +
           (input.blind.empty() ? "" : "; " + input.blind);
  return blind;
}

std::optional<std::string> Mission::blind_too_long(const MissionInput& input) {
  if (!sight_ || input.blind.empty()) sight_ = input.now;
  const bool turns = input.bus.head.health == hal::HeadHealth::kReady;
  if (!turned_ || turns) turned_ = input.now;
  const auto for_so_long = [&](const char* what) {
    char line[80];
    std::snprintf(line, sizeof line, "%s for %.0f s", what, to_seconds(config_.longest_blind));
    return std::string(line);
  };
  if (input.now - *sight_ > config_.longest_blind)
    return for_so_long("nothing has been seen") + ": " + input.blind;
  if (input.now - *turned_ > config_.longest_blind) return for_so_long("the head has not been ready to turn");
  return std::nullopt;
}

MotionOrder Mission::rest(const MissionInput& input) const {
  MotionOrder order;
  order.look = look_;
  order.plan.newest_frame = input.last_look;
  return order;
}

MotionOrder Mission::starting(const MissionInput& input) {
  if (input.bus.head.health == hal::HeadHealth::kReady && input.bus.walker == hal::WalkerHealth::kReady)
    begin_look_around();
  look_ = input.head;
  return rest(input);
}

void Mission::begin_look_around() {
  begin_look_again();
  exploring_ = next_view_.has_value();
  if (exploring_) tour_ = Tour();
}

void Mission::begin_look_again() {
  state_ = MissionState::kLookAround;
  exploring_ = false;
  looked_.clear();
  tour_ = Tour(config_.viewpoints, config_.frames_per_view);
  ++counters_.look_arounds;
}

MotionOrder Mission::look_around(const MissionInput& input) {
  // A map from before says nothing of what is here until it is known where here is.
  if (input.placed == finding_place_) {
    finding_place_ = !input.placed;
    finding_place_ ? begin_look_again() : begin_look_around();
  }
  if (!input.faulty && tour_.look(input.head)) {
    ++views_taken_;
    looked_.push_back(input.map_from_chest * config_.neck.chest_from_camera(input.head));
  }
  if (exploring_ && tour_.done()) tour_ = next_look(input);
  if (!tour_.done())
    look_ = tour_.direction();
  else if (finding_place_)
    give_up(
        "the views fit nowhere near in the map from before: set the robot up as it stood then, or begin "
        "without that map");
  else
    state_ = goal_ ? MissionState::kWalk : MissionState::kWaitGoal;
  return rest(input);
}

/// At the best direction; at none when nothing is left to gain.
Tour Mission::next_look(const MissionInput& input) {
  const auto looks = next_view_->turns(input.mapper.voxels(), input.map_from_chest, input.head, looked_);
  if (looks.empty()) return {};
  return Tour({looks.front().head}, config_.frames_per_view);
}

MotionOrder Mission::walk_on(const MissionInput& input) {
  const nav::Committed& committed = input.bus.committed;
  if (!goal_) {
    state_ = MissionState::kWaitGoal;
    return rest(input);
  }
  const bool known = keep_up(committed), threat = threatened(input);
  if (!known || threat) {
    if (threat && walk_) ++counters_.threats;
    walk_.reset();
    look_ = gaze(input, {});
    if (threat && !config_.replan) give_up("an obstacle came onto steps that were committed");
    return rest(input);
  }
  if (walk_ && !walk_->fits(committed) && !(walk_->carry_over(committed) && stable(walk_->walk)))
    walk_.reset();
  if (!walk_ && planned_once_ && !config_.replan) {
    give_up("the walk left the plan, which may not be made again");
    return rest(input);
  }
  plan(input);
  if (committed.at_rest && at_goal(committed)) {
    state_ = MissionState::kArrived;
    second_look_.forget();
    reason_ = nav::describe_shortfall(last_plan_, *goal_);
    return rest(input);
  }
  const Gate gate = walk_ ? check_gate(input) : Gate{};
  const std::size_t left = walk_ ? walk_->left(committed) : 0;
  look_ = gaze(input, gate);
  if (committed.at_rest && gate.open < std::min(kStepsToStart, std::max<std::size_t>(left, 1)))
    return held_up(input, gate);
  if (!committed.at_rest && committed.next_index > 0) fruitless_ = 0;
  MotionOrder order;
  order.look = look_;
  // A plan of no steps, behind a gate that is shut, still takes the place of the last one. A walk that is
  // stopping takes none: the next session goes on from where this one ends.
  if (walk_ && !committed.stopping) order.walk = MotionOrder::Walk::kPlan;
  if (walk_) order.plan = walk_->next_steps(gate.open, committed);
  order.plan.newest_frame = input.last_look;
  return order;
}

Gate Mission::check_gate(const MissionInput& input) const {
  const std::size_t done = walk_->done(input.bus.committed);
  const auto check = [&](const nav::FloorMap& floor) {
    return gate_.check(walk_->walk, done, floor, on_floor(input.map_from_chest), input.now);
  };
  Gate gate = check(second_look_.floor(input.mapper));
  // What may have gone is looked at, not walked into.
  if (second_look_.on())
    gate.open = std::min({gate.open, check(input.mapper.floor()).open,
                          gate_.clear_steps(walk_->walk, done, input.mapper.floor())});
  return gate;
}

double Mission::short_of_goal() const {
  if (!goal_ || !last_plan_ || last_plan_.short_of_goal == nav::NoPath::kNone) return 0;
  return (last_plan_.path.end - goal_->position).norm();
}

bool Mission::at_goal(const nav::Committed& committed) const {
  const Pose2 base = committed.stance.base();
  if ((base.position() - goal_->position).norm() >
      std::max(config_.goal_tolerance,
               last_plan_ ? (last_plan_.path.end - goal_->position).norm() + config_.goal_tolerance : 0.0))
    return false;
  return !goal_->yaw || std::abs(wrap_angle(base.yaw - *goal_->yaw)) <= config_.yaw_tolerance;
}

void Mission::plan(const MissionInput& input) {
  if (planned_once_ && !config_.replan) return;
  unstable_.clear();
  const nav::Committed& committed = input.bus.committed;
  const nav::FloorMap& floor = second_look_.floor(input.mapper);
  auto [found, candidate] = ways_.find(floor, committed, *goal_);
  last_plan_ = std::move(found);
  ++counters_.plans;
  if (!last_plan_) {
    if (walk_ && !gate_.clear(walk_->walk, walk_->done(committed), floor)) walk_.reset();
    return;
  }
  if (walk_ && !worth_changing(candidate, committed, floor)) return;
  if (stable(candidate))
    adopt(last_plan_.path, std::move(candidate), committed);
  else if (walk_ && !gate_.clear(walk_->walk, walk_->done(committed), floor))
    walk_.reset();
}

/// The forecaster takes in what has been committed since the last frame. False when it cannot: then nothing
/// can be said of what would follow on it.
bool Mission::keep_up(const nav::Committed& committed) {
  if (committed.next_index == 0 || committed.stopping) {  // the next walk begins at rest in that stance
    forecaster_.rest_at(committed.stance);
    forecast_session_ = committed.session;
    forecast_from_ = committed.next_index;
  }
  if (forecast_session_ != committed.session || forecast_from_ > committed.next_index) return false;
  for (; forecast_from_ < committed.next_index; ++forecast_from_) {
    const nav::CommittedStep* next = committed.step(forecast_from_);
    if (next == nullptr || !forecaster_.commit(next->step)) return false;
  }
  return true;
}

/// Steps that are committed are walked to their end whatever happens; what stands on them must at least not
/// be followed by more.
bool Mission::threatened(const MissionInput& input) const {
  const nav::Committed& committed = input.bus.committed;
  if (committed.at_rest) return false;
  std::vector<Pose2> coming;
  for (std::uint32_t back = 1; back <= std::min(kStepsAhead, committed.next_index); ++back) {
    const nav::CommittedStep& next = *committed.step(committed.next_index - back);
    coming.push_back(nav::gait_base(next.stance, next.step.foot, config_.gait));
    if (nav::is_on_low(input.mapper.floor(), config_.gait, next.stance.at(next.step.foot))) return true;
  }
  return gate_.hits(coming, input.mapper.floor());
}

/// Whether the pattern generator could walk it without tipping.
bool Mission::stable(const nav::Walk& candidate) {
  unstable_ = nav::complaint(forecaster_.foresee(candidate.steps), config_.gait.zmp_margin);
  return unstable_.empty();
}

bool Mission::worth_changing(const nav::Walk& candidate, const nav::Committed& committed,
                             const nav::FloorMap& floor) const {
  const std::size_t done = walk_->done(committed);
  // It led beside the goal, or drift that was found on the way did, and the robot has come to its end.
  if (committed.at_rest && done == walk_->walk.steps.size() && !at_goal(committed)) return true;
  if (!gate_.clear(walk_->walk, done, floor)) return true;
  const auto to_go = [&](const nav::Path& path) { return (path.end - goal_->position).norm(); };
  if (goal_->near && to_go(last_plan_.path) + config_.goal_tolerance < to_go(walk_->path)) return true;
  const auto left = static_cast<int>(walk_->walk.steps.size() - done);
  return static_cast<int>(candidate.steps.size()) + config_.fewer_steps < left;
}

void Mission::adopt(nav::Path path, nav::Walk walk, const nav::Committed& committed) {
  if (walk_ && !walk_->goes_on_as(walk, committed)) ++counters_.replans;
  walk_ = CurrentWalk{committed.session, committed.next_index, std::move(path), std::move(walk)};
  planned_once_ = true;
}

hal::HeadAngles Mission::gaze(const MissionInput& input, const Gate& gate) const {
  const Pose2 base = input.bus.committed.stance.base();
  Eigen::Vector2d target = base * Eigen::Vector2d(config_.look_distance, 0);
  const auto missing = middle_of(gate.missing, input.mapper.floor().grid);
  // What holds up the next steps comes first. What is near counts as well, however many steps lead there:
  // sideway steps are short, and floor that has come too near cannot be looked at any more.
  if (missing &&
      (gate.open < 2 * kStepsToStart || (*missing - base.position()).norm() < config_.look_distance)) {
    target = *missing;
  } else if (walk_) {
    for (std::size_t i = walk_->done(input.bus.committed); i < walk_->walk.bases.size(); ++i) {
      const Pose2& b = walk_->walk.bases[i];
      target = b * Eigen::Vector2d(config_.look_distance / 2, 0);
      if ((b.position() - base.position()).norm() > config_.look_distance / 2) break;
      if (std::abs(wrap_angle(b.yaw - base.yaw)) > config_.head.upper.pan) break;
    }
  }
  return look_at({target.x(), target.y(), 0}, input.map_from_chest, config_.neck, config_.head);
}

MotionOrder Mission::held_up(const MissionInput& input, const Gate& gate) {
  const bool unstable = !walk_ && !unstable_.empty();
  if (fruitless_ == 0) held_up_ = input.now;
  ++fruitless_;
  if (second_look_.on() && (fruitless_ > 2 || !last_plan_ || unstable)) {
    end_second_look(input);
    return rest(input);
  }
  if (unstable) {
    give_up(unstable_);
    return rest(input);
  }
  if (fruitless_ > 2 * config_.attempts || (!last_plan_ && fruitless_ > 2)) {
    if (!last_plan_ && look_again_for_a_way(input)) return rest(input);
    if (!last_plan_) {
      std::string reason = std::string("no way to the goal: ") + nav::describe(last_plan_.reason);
      if (last_plan_.nearest) reason += at("; the nearest place that can be reached is", *last_plan_.nearest);
      give_up(std::move(reason));
    } else if (gate.blocked) {
      give_up("an obstacle stands on the way that was planned");
    } else if (!gate.missing.empty()) {
      give_up(at("the floor cannot be seen at", input.mapper.floor().grid.centre(gate.missing.front())));
    } else {
      give_up("no step could be placed");
    }
    return rest(input);
  }
  ++counters_.pauses;
  if (fruitless_ % 2 == 0 || gate.missing.empty()) {
    begin_look_again();
    return rest(input);
  }
  state_ = MissionState::kLookAhead;
  std::vector<hal::HeadAngles> directions;
  for (const double pan : {0.0, 0.26, -0.26})
    for (const double tilt : {0.0, 0.3, -0.3})
      directions.push_back(limited({look_.pan + pan, look_.tilt + tilt}, config_.head));
  tour_ = Tour(std::move(directions), config_.frames_per_view);
  return rest(input);
}

bool Mission::look_again_for_a_way(const MissionInput& input) {
  const nav::Committed& committed = input.bus.committed;
  const Pose2 base = nav::gait_base(committed.stance, committed.last_foot, config_.gait);
  if (!second_look_.begin(input.mapper, base.position(), held_up_)) return false;
  if (!ways_.leads(second_look_.floor(input.mapper), committed, *goal_)) {
    second_look_.end(input.mapper, base.position());
    return false;
  }
  fruitless_ = 0;
  return true;
}

void Mission::end_second_look(const MissionInput& input) {
  second_look_.end(input.mapper, input.bus.committed.stance.base().position());
  walk_.reset();
  fruitless_ = 0;
}

MotionOrder Mission::look_ahead(const MissionInput& input) {
  if (!input.faulty) tour_.look(input.head);
  if (tour_.done()) {
    state_ = MissionState::kWalk;
    return rest(input);
  }
  look_ = tour_.direction();
  if (walk_ && walk_->fits(input.bus.committed)) {
    const std::size_t left = walk_->left(input.bus.committed);
    if (check_gate(input).open >= std::min(2 * kStepsToStart, left)) state_ = MissionState::kWalk;
  }
  return rest(input);
}

void Mission::give_up(std::string reason) {
  state_ = MissionState::kStopped;
  reason_ = std::move(reason);
  walk_.reset();
  second_look_.forget();
  finding_place_ = false;  // it may be tried again
}

}  // namespace headway::runtime
