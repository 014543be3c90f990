// All that the safety states can come to, explored; and that a table with any cell changed would be found
// out.
#include "runtime/safety.h"

#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "tests/runtime/safety_model.h"

namespace headway::runtime {
namespace {

using Level = SourceLevel;
constexpr std::array kAll{Level::kAwaited, Level::kFine, Level::kPoor, Level::kLost};
constexpr std::array kNoPoor{Level::kAwaited, Level::kFine, Level::kLost};
constexpr std::array kNoLost{Level::kAwaited, Level::kFine, Level::kPoor};
constexpr std::array kPerhaps{Level::kUnused, Level::kFine, Level::kLost};
constexpr std::array kCycleLevels{Level::kFine, Level::kPoor, Level::kLost};

/// As the watchdogs' table has them.
const std::array<ModelSource, kSources> kEverySource{{{SafetySource::kBus, kAll, true},
                                                      {SafetySource::kControl, kNoPoor, true},
                                                      {SafetySource::kDrives, kAll, true},
                                                      {SafetySource::kTime, kPerhaps, true},
                                                      {SafetySource::kOperator, kPerhaps, true},
                                                      {SafetySource::kCycles, kCycleLevels, true},
                                                      {SafetySource::kPictures, kAll, false},
                                                      {SafetySource::kMap, kAll, false},
                                                      {SafetySource::kPose, kNoLost, false}}};
/// One of each kind, for when everything happens at once.
const std::array<ModelSource, 3> kOneOfAKind{{{SafetySource::kBus, kAll, true},
                                              {SafetySource::kOperator, kPerhaps, true},
                                              {SafetySource::kMap, kAll, false}}};

bool may_come(Level level) { return level != Level::kAwaited && level != Level::kUnused; }

/// Of each source, what it may change to; and nothing.
std::vector<decltype(Happening::change)> changes(std::span<const ModelSource> sources) {
  std::vector<decltype(Happening::change)> all{std::nullopt};
  for (std::size_t i = 0; i < sources.size(); ++i)
    for (std::uint8_t l = 0; l < sources[i].levels.size(); ++l)
      if (may_come(sources[i].levels[l])) all.push_back(std::pair{i, l});
  return all;
}

/// One thing after the other, in any order.
std::vector<Happening> one_by_one(std::span<const ModelSource> sources) {
  std::vector<Happening> all;
  for (const auto& change : changes(sources)) all.push_back({.change = change});
  all.push_back({.reset = true});
  all.push_back({.fault = true});
  all.push_back({.stop = true});
  for (const auto goal :
       {Happening::Goal::kWithdrawn, Happening::Goal::kGiven, Happening::Goal::kGivenTooLate})
    all.push_back({.goal = goal});
  for (const auto walk : {Happening::Walk::kLands, Happening::Walk::kCommits}) all.push_back({.walk = walk});
  return all;
}

/// Any of them in one cycle, and two sources at once.
std::vector<Happening> all_at_once(std::span<const ModelSource> sources) {
  std::vector<Happening> all;
  const auto each = changes(sources);
  for (const auto& change : each)
    for (const auto& another : each) {
      if (another && (!change || another->first <= change->first)) continue;
      for (int flags = 0; flags < 8; ++flags)
        for (int goal = 0; goal < 4; ++goal)
          for (int walk = 0; walk < 3; ++walk)
            all.push_back({(flags & 1) != 0, (flags & 2) != 0, (flags & 4) != 0,
                           static_cast<Happening::Goal>(goal), static_cast<Happening::Walk>(walk), change,
                           another});
    }
  return all;
}

struct Explored {
  std::vector<std::size_t> moments;  ///< in the order in which they were reached, the nearest first
  std::uint64_t cycles = 0;
  std::string broken;  ///< the first rule that was, if any
};

/// Breadth first, until nothing new is reached or a rule is broken.
Explored explore(SafetyModel& model, const std::vector<Happening>& happenings) {
  Explored out;
  std::vector<bool> reached(model.size());
  const auto reach = [&](const Moment& moment) {
    const std::size_t index = model.index_of(moment);
    if (reached[index]) return;
    reached[index] = true;
    out.moments.push_back(index);
  };
  reach({});
  for (std::size_t i = 0; i < out.moments.size() && model.broken().empty(); ++i) {
    const Moment before = model.moment_of(out.moments[i]);
    for (const Happening& happening : happenings) {
      reach(model.cycle(before, happening));
      ++out.cycles;
    }
  }
  out.broken = model.broken();
  return out;
}

/// From here: asked to stop, it rests after the steps that are committed, whatever is tried meanwhile.
bool comes_to_rest(SafetyModel& model, Moment moment) {
  moment = model.cycle(moment, {.stop = true});
  for (int i = 0; i < SafetyModel::kMostLeft; ++i) {
    moment = model.cycle(moment, {.goal = Happening::Goal::kGiven, .walk = Happening::Walk::kCommits});
    moment = model.cycle(moment, {.walk = Happening::Walk::kLands});
  }
  return moment.left == 0;
}

/// From here: at rest, with everything there, the fault reset and a goal given, it walks.
bool walks_again(SafetyModel& model, std::span<const ModelSource> sources, Moment moment) {
  for (int i = 0; i < SafetyModel::kMostLeft; ++i)
    moment = model.cycle(moment, {.walk = Happening::Walk::kLands});
  for (std::size_t i = 0; i < sources.size(); ++i)
    for (std::uint8_t l = 0; l < sources[i].levels.size(); ++l)
      if (sources[i].levels[l] == Level::kFine) moment = model.cycle(moment, {.change = std::pair{i, l}});
  moment = model.cycle(moment, {.reset = true});
  moment = model.cycle(moment, {.goal = Happening::Goal::kGiven});
  moment = model.cycle(moment, {});
  moment = model.cycle(moment, {.walk = Happening::Walk::kCommits});
  return moment.left > 0;
}

TEST(SafetyStates, AreExploredWithTheSourcesOfTheWatchdogs) {
  for (std::size_t i = 0; i < kSources; ++i) {
    const ModelSource& source = kEverySource[i];
    EXPECT_EQ(static_cast<std::size_t>(source.source), i);
    EXPECT_EQ(source.levels[0] == Level::kAwaited, kWatchdogs[i].awaited) << name(source.source);
    EXPECT_EQ(source.levels.back() == Level::kLost, kWatchdogs[i].lost != kNeverLost) << name(source.source);
  }
}

TEST(SafetyStatesSlow, KeepTheirPromisesInWhateverOrderThingsFailAndComeBack) {
  SafetyModel model(kEverySource, kSafetyTable);
  const Explored all = explore(model, one_by_one(kEverySource));
  std::printf("one after the other: %zu states, %llu cycles\n", all.moments.size(),
              static_cast<unsigned long long>(all.cycles));
  EXPECT_EQ(all.broken, "");
  EXPECT_GT(all.moments.size(), 100000U);
  std::array<std::size_t, kSafetyStates> in_state{};
  for (const std::size_t index : all.moments) {
    const Moment moment = model.moment_of(index);
    ++in_state[static_cast<std::size_t>(moment.state)];
    ASSERT_TRUE(comes_to_rest(model, moment)) << name(moment.state);
    ASSERT_TRUE(walks_again(model, kEverySource, moment)) << name(moment.state);
  }
  EXPECT_EQ(model.broken(), "");
  for (std::size_t s = 0; s < kSafetyStates; ++s)
    EXPECT_GT(in_state[s], 0U) << name(static_cast<SafetyState>(s));
}

TEST(SafetyStates, KeepTheirPromisesWhenThingsHappenAtOnce) {
  SafetyModel model(kOneOfAKind, kSafetyTable);
  const Explored all = explore(model, all_at_once(kOneOfAKind));
  std::printf("all at once: %zu states, %llu cycles\n", all.moments.size(),
              static_cast<unsigned long long>(all.cycles));
  EXPECT_EQ(all.broken, "");
  EXPECT_GT(all.moments.size(), 500U);
}

/// Two tables that lead to the same in every state, whatever a cycle sees.
bool same(const SafetyTable& one, const SafetyTable& other) {
  SafetyModel first(kOneOfAKind, one), second(kOneOfAKind, other);
  const auto happenings = all_at_once(kOneOfAKind);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Moment moment = first.moment_of(i);
    if (moment.left > 0 || moment.stopping || moment.given) continue;  // the walk has no say in the states
    for (const Happening& happening : happenings)
      if (happening.walk == Happening::Walk::kNothing &&
          first.index_of(first.cycle(moment, happening)) != second.index_of(second.cycle(moment, happening)))
        return false;
  }
  return true;
}

TEST(SafetyStatesSlow, AreFoundOutWhereverTheirTableIsWrong) {
  const auto happenings = all_at_once(kOneOfAKind);
  int found = 0, equal = 0;
  for (std::size_t s = 0; s < kSafetyStates; ++s) {
    for (std::size_t e = 0; e < kSafetyEvents; ++e) {
      int of_cell = 0;
      for (std::size_t to = 0; to < kSafetyStates; ++to) {
        SafetyTable wrong = kSafetyTable;
        if (wrong[s][e] == static_cast<SafetyState>(to)) continue;
        wrong[s][e] = static_cast<SafetyState>(to);
        SafetyModel model(kOneOfAKind, wrong);
        const bool finds = !explore(model, happenings).broken.empty();
        found += finds;
        of_cell += finds;
        if (finds) continue;
        // What comes later in the same cycle leads to the same.
        EXPECT_TRUE(same(kSafetyTable, wrong))
            << name(static_cast<SafetyState>(s)) << " / " << name(static_cast<SafetyEvent>(e)) << " -> "
            << name(static_cast<SafetyState>(to)) << " is not found out";
        std::printf("%s / %s -> %s leads to the same\n", name(static_cast<SafetyState>(s)),
                    name(static_cast<SafetyEvent>(e)), name(static_cast<SafetyState>(to)));
        ++equal;
      }
      EXPECT_GT(of_cell, 0) << name(static_cast<SafetyState>(s)) << " / " << name(static_cast<SafetyEvent>(e))
                            << ": nothing reaches this cell";
    }
  }
  std::printf("wrong tables: %d found out, %d that lead to the same in every cycle\n", found, equal);
  EXPECT_EQ(found + equal, static_cast<int>(kSafetyStates * kSafetyEvents * (kSafetyStates - 1)));
  EXPECT_LT(equal, 30);
}

}  // namespace
}  // namespace headway::runtime
