#include "runtime/cycle.h"

#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/clock.h"
#include "hal/error.h"
#include "tests/heap_count.h"

namespace headway::runtime {
namespace {

constexpr Duration kPeriod = seconds(0.005);

/// Rounds whose work takes so long [us].
class Rounds {
 public:
  explicit Rounds(const CycleLimits& limits = {}) : cycle(kPeriod, limits) {}
  CycleHealth go(Duration work = {}, Duration oversleep = {}) {
    clock.sleep_until(cycle.due());
    clock.advance(oversleep);
    const CycleHealth health = cycle.begin(clock.now());
    clock.advance(work);
    cycle.end(clock.now());
    return health;
  }
  hal::ManualClock clock;
  Cycle cycle;
};

TEST(Cycle, KeepsItsPhaseThroughLateRounds) {
  Rounds rounds;
  rounds.go(seconds(0.001));
  rounds.go(seconds(0.002), seconds(0.0049));
  EXPECT_EQ(rounds.clock.now(), at_seconds(0.0119));
  rounds.go(seconds(0.004));
  EXPECT_EQ(rounds.clock.now(), at_seconds(0.0159)) << "began late, missed nothing";
  rounds.go();
  EXPECT_EQ(rounds.clock.now(), at_seconds(0.0159));
  rounds.go();
  EXPECT_EQ(rounds.clock.now(), at_seconds(0.020)) << "as if nothing had been";
  EXPECT_EQ(rounds.cycle.missed(), 0U);
}

TEST(Cycle, BeginsWithItsFirstRound) {
  Rounds rounds;
  rounds.clock.set(at_seconds(7.003));
  EXPECT_EQ(rounds.go(), CycleHealth::kOnTime);
  EXPECT_EQ(rounds.cycle.due(), at_seconds(7.008));
  EXPECT_EQ(rounds.cycle.wake_up_delay().max(), Duration(0));
  EXPECT_EQ(rounds.cycle.missed(), 0U);
}

TEST(Cycle, TellsWakeUpDelayAndRunTimeApart) {
  Rounds rounds;
  rounds.go();
  rounds.go(seconds(0.001), seconds(0.0003));
  EXPECT_EQ(rounds.cycle.wake_up_delay().max(), seconds(0.0003));
  EXPECT_EQ(rounds.cycle.run_time().max(), seconds(0.001));
}

// Model: a slot of the time table is missed when no round began within it.
RC_GTEST_PROP(Cycle, CountsThePeriodsInWhichNoRoundBegan, ()) {
  const auto works = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 40000));
  Rounds rounds;
  std::vector<bool> began;
  for (const int work : works) {
    const Time due = rounds.cycle.due();
    RC_ASSERT((due - Time{}) % kPeriod == Duration(0));
    rounds.clock.sleep_until(due);
    const Time now = rounds.clock.now();
    const auto slot = static_cast<std::size_t>((now - Time{}) / kPeriod);
    // One that the round before ran into begins within the next slot, or in the one after if none is left.
    began.resize(std::max(began.size(), slot + 1), false);
    RC_ASSERT(!began[slot]);
    began[slot] = true;
    rounds.go(std::chrono::microseconds(work));
  }
  const auto missed = static_cast<std::uint64_t>(std::count(began.begin(), began.end(), false));
  RC_ASSERT(rounds.cycle.missed() == missed);
}

RC_GTEST_PROP(Cycle, FailsWhenMoreAreMissedWithinTheWindowThanAreBorne, ()) {
  CycleLimits limits;
  limits.most_missed = *rc::gen::inRange(0, 12);
  limits.within = *rc::gen::inRange(1, 40) * kPeriod;
  const auto works = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 5));
  Rounds rounds(limits);
  std::vector<Time> missed;
  for (const int work : works) {
    const Time due = rounds.cycle.due(), now = std::max(due, rounds.clock.now());
    for (Time slot = due; slot + kPeriod <= now; slot += kPeriod) missed.push_back(slot);
    const auto lately =
        std::count_if(missed.begin(), missed.end(), [&](Time slot) { return slot > now - limits.within; });
    const CycleHealth expected = lately > limits.most_missed       ? CycleHealth::kFailing
                                 : lately > limits.most_missed / 4 ? CycleHealth::kLate
                                                                   : CycleHealth::kOnTime;
    RC_ASSERT(rounds.go(work * work * kPeriod) == expected);
    RC_ASSERT(rounds.cycle.health() == expected);
  }
}

TEST(Cycle, IsOnTimeAgainAfterTheWindow) {
  Rounds rounds;
  EXPECT_EQ(rounds.go(20 * kPeriod), CycleHealth::kOnTime);
  EXPECT_EQ(rounds.go(), CycleHealth::kLate) << "19 were missed";
  EXPECT_EQ(rounds.go(22 * kPeriod), CycleHealth::kLate);
  EXPECT_EQ(rounds.go(), CycleHealth::kFailing);
  while (rounds.cycle.due() < at_seconds(1.185)) EXPECT_NE(rounds.go(), CycleHealth::kOnTime);
  EXPECT_EQ(rounds.go(), CycleHealth::kOnTime);
}

TEST(Cycle, SurvivesAStandstillOfHours) {
  Rounds rounds;
  rounds.go(seconds(7200));
  EXPECT_EQ(rounds.go(), CycleHealth::kFailing);
  EXPECT_EQ(rounds.cycle.missed(), 7200U * 200 - 1);
  EXPECT_GT(rounds.cycle.due(), rounds.clock.now());
}

TEST(Cycle, UsesNoHeap) {
  Rounds rounds;
  const std::uint64_t before = heap_allocations();
  for (int i = 0; i < 100; ++i) rounds.go(i * seconds(0.001));
  EXPECT_EQ(heap_allocations(), before);
}

TEST(Cycle, RefusesLimitsThatItCannotKeep) {
  EXPECT_THROW(Cycle(kPeriod, {.most_missed = 256, .within = seconds(1)}), InputError);
  EXPECT_THROW(Cycle(kPeriod, {.most_missed = -1, .within = seconds(1)}), InputError);
  EXPECT_THROW(Cycle(kPeriod, {.most_missed = 20, .within = seconds(0)}), InputError);
}

}  // namespace
}  // namespace headway::runtime
