// Everything that can happen to the safety states, one bus cycle after the other, with a walk as the step
// stack leads it; judged in each cycle by rules that know nothing of the table.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "runtime/safety.h"

namespace headway::runtime {

/// Levels that a source goes through, from what it is at first.
struct ModelSource {
  SafetySource source;
  std::span<const SourceLevel> levels;
  bool stops_at_once;  ///< lost, it ends what a goal that was given before may do, in every cycle that it is
                       ///< so
};

/// One moment. All of it that matters for what comes next, and for the verdict.
struct Moment {
  SafetyState state = SafetyState::kInit;
  std::array<std::uint8_t, kSources> level{};  ///< index into ModelSource::levels
  enum class Goal : std::uint8_t { kNone, kVoid, kValid } goal = Goal::kNone;
  std::uint8_t left = 0;  ///< committed steps that have not landed, at most three and the one that lands now
  bool stopping = false;  ///< this walk takes no more steps
  bool given = false;     ///< a goal was given since the last moment in a stop
};

/// What happens in one cycle.
struct Happening {
  bool reset = false, fault = false, stop = false;
  enum class Goal : std::uint8_t { kKept, kWithdrawn, kGiven, kGivenTooLate } goal = Goal::kKept;
  enum class Walk : std::uint8_t { kNothing, kLands, kCommits } walk = Walk::kNothing;
  std::optional<std::pair<std::size_t, std::uint8_t>> change{}, another{};  ///< of a source, to a level
};

class SafetyModel {
 public:
  static constexpr std::uint8_t kMostLeft = 3;

  SafetyModel(std::span<const ModelSource> sources, const SafetyTable& table)
      : sources_(sources), table_(table) {}

  std::size_t size() const;
  std::size_t index_of(const Moment& moment) const;
  Moment moment_of(std::size_t index) const;

  /// One cycle. What it breaks is kept in broken().
  Moment cycle(const Moment& before, const Happening& happening);
  const std::string& broken() const { return broken_; }

  /// Every source as it should be.
  bool all_fine(const Moment& moment) const;

 private:
  template <class Test>
  bool any(const Moment& moment, Test test) const {
    for (std::size_t i = 0; i < sources_.size(); ++i)
      if (test(sources_[i].levels[moment.level[i]], sources_[i].stops_at_once)) return true;
    return false;
  }
  void judge_state(const Moment& before, const Moment& after, const Happening& happening);
  void judge_walk(const Moment& before, const Moment& after, bool commits);
  void require(bool kept, const char* rule) {
    if (!kept && broken_.empty()) broken_ = rule;
  }

  std::span<const ModelSource> sources_;
  SafetyTable table_;
  std::string broken_;
};

}  // namespace headway::runtime
