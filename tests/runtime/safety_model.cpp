#include "tests/runtime/safety_model.h"

namespace headway::runtime {
namespace {

constexpr std::size_t kGoals = 3, kLefts = SafetyModel::kMostLeft + 1;
using Goal = Moment::Goal;

WatchdogTable told() {
  WatchdogTable table;
  table.fill({kSaysItself, kSaysItself, false});
  return table;
}

bool missing(SourceLevel level) { return level != SourceLevel::kFine && level != SourceLevel::kUnused; }

}  // namespace

std::size_t SafetyModel::size() const {
  std::size_t size = kSafetyStates * kGoals * kLefts * 2 * 2;
  for (const ModelSource& source : sources_) size *= source.levels.size();
  return size;
}

std::size_t SafetyModel::index_of(const Moment& m) const {
  std::size_t index = static_cast<std::size_t>(m.state);
  for (std::size_t i = 0; i < sources_.size(); ++i) index = index * sources_[i].levels.size() + m.level[i];
  index = index * kGoals + static_cast<std::size_t>(m.goal);
  index = index * kLefts + m.left;
  return (index * 2 + m.stopping) * 2 + m.given;
}

Moment SafetyModel::moment_of(std::size_t index) const {
  const auto take = [&](std::size_t base) {
    const std::size_t digit = index % base;
    index /= base;
    return static_cast<std::uint8_t>(digit);
  };
  Moment m;
  m.given = take(2) != 0;
  m.stopping = take(2) != 0;
  m.left = take(kLefts);
  m.goal = static_cast<Goal>(take(kGoals));
  for (std::size_t i = sources_.size(); i-- > 0;) m.level[i] = take(sources_[i].levels.size());
  m.state = static_cast<SafetyState>(index);
  return m;
}

bool SafetyModel::all_fine(const Moment& moment) const {
  return !any(moment, [](SourceLevel level, bool) { return missing(level); });
}

Moment SafetyModel::cycle(const Moment& before, const Happening& happening) {
  Moment after = before;
  for (const auto& change : {happening.change, happening.another})
    if (change) after.level[change->first] = change->second;
  using Word = Happening::Goal;
  if (happening.goal == Word::kWithdrawn) after.goal = Goal::kNone;
  if (happening.goal == Word::kGiven) after.goal = Goal::kValid;
  if (happening.goal == Word::kGivenTooLate) after.goal = Goal::kVoid;

  static const WatchdogTable table = told();
  Watchdogs watchdogs(table);
  for (std::size_t i = 0; i < sources_.size(); ++i)
    watchdogs.say(sources_[i].source, sources_[i].levels[after.level[i]]);
  watchdogs.look({});
  SafetyInput input{.reset = happening.reset, .fault = happening.fault, .stop_asked = happening.stop};
  input.goal = after.goal != Goal::kNone;
  input.goal_after = after.goal == Goal::kVoid ? ~std::uint32_t{0} : 0;
  Safety safety(table_, before.state);
  safety.cycle(input, watchdogs);
  after.state = safety.state();
  if (safety.report().stops != 0 && after.goal == Goal::kValid) after.goal = Goal::kVoid;

  // The walk, as the bus loop leads it.
  using Walk = Happening::Walk;
  if (!may_walk(after.state) && after.left > 0) after.stopping = true;
  bool fresh = true;  // no step commits on an old map
  for (std::size_t i = 0; i < sources_.size(); ++i)
    if (sources_[i].source == SafetySource::kMap) fresh = !missing(sources_[i].levels[after.level[i]]);
  const bool commits = happening.walk == Walk::kCommits && fresh && !after.stopping &&
                       after.left < kMostLeft &&
                       (after.left == 0 ? may_begin_to_walk(after.state) : may_walk(after.state));
  if (commits) ++after.left;
  if (happening.walk == Walk::kLands && after.left > 0) --after.left;
  if (after.left == 0) after.stopping = false;

  if (happening.goal == Word::kGiven) after.given = true;
  judge_state(before, after, happening);
  judge_walk(before, after, commits);
  const bool lost =
      any(after, [](SourceLevel level, bool stops) { return stops && level == SourceLevel::kLost; });
  if (stopped(after.state) || happening.stop || lost) after.given = false;
  return after;
}

/// What the states are, each told by what has happened.
void SafetyModel::judge_state(const Moment& before, const Moment& after, const Happening& happening) {
  using enum SafetyState;
  const SafetyState was = before.state, is = after.state;
  const bool lost =
      any(after, [](SourceLevel level, bool stops) { return stops && level == SourceLevel::kLost; });
  const bool blind =
      any(after, [](SourceLevel level, bool stops) { return !stops && level == SourceLevel::kLost; });
  const bool fine = all_fine(after), ordered = after.goal == Goal::kValid;
  const bool reset = happening.reset && !happening.fault;

  const bool fault = happening.fault || (was == kFault && !reset);
  require((is == kFault) == fault, "a fault holds until it is gone and reset, and is nothing else");
  if (fault) return;
  const bool ends = happening.stop || was == kFault || (may_walk(was) && (lost || blind));
  const bool ends_still = was == kSafeStop && !(ordered && !lost);
  require((is == kSafeStop) == (ends || ends_still),
          "a stop, or a loss on the way, holds until a goal is given anew with nothing lost");
  if (is == kSafeStop) return;
  if (was == kSafeStop)
    return require(is == kInit, "after a stop everything is looked at as at the beginning");
  require((is == kActive) == (ordered && fine), "with a goal and everything there it is active");
  require((is == kReady) == (!ordered && fine), "without a goal and everything there it is ready");
  require((is == kDegraded) == (ordered && !fine && may_walk(was)),
          "with a goal it was about, and something poor, it is degraded");
}

/// What the robot does.
void SafetyModel::judge_walk(const Moment& before, const Moment& after, bool commits) {
  const bool lost = any(after, [](SourceLevel level, bool) { return level == SourceLevel::kLost; });
  if (after.left > 0 && !after.stopping)
    require(may_walk(after.state) && !lost,
            "what is lost, stopped or at fault ends the walk in the same cycle");
  if (!commits) return;
  require(after.given, "no step but for a goal that was given after the last stop and the last loss");
  require(!lost && !before.stopping, "no step while something is lost, nor after a walk was ended");
  require(before.left > 0 || all_fine(after), "no walk begins while something is missing");
}

}  // namespace headway::runtime
