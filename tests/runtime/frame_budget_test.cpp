#include "runtime/frame_budget.h"

#include <functional>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::runtime {
namespace {

using Level = FrameLevel;
const Duration kPeriod = seconds(0.033);

FrameBudget thirty_hertz() { return FrameBudget({.period = kPeriod}); }

/// A computer on which the stages take so long at full effort.
void work(FrameBudget& budget, const StageTimes& stages, int frames) {
  for (int i = 0; i < frames; ++i) budget.took(at_level(stages, budget.level()).total());
}

StageTimes stages(double see, double map, double floor, double plan) {
  return {seconds(see), seconds(map), seconds(floor), seconds(plan)};
}

TEST(FrameBudget, LeavesNothingOutWhileThereIsTime) {
  FrameBudget budget = thirty_hertz();
  work(budget, stages(0.020, 0.005, 0.001, 0.006), 1000);
  EXPECT_EQ(budget.level(), Level::kFull);
}

TEST(FrameBudget, GivesUpTheEveryFrameThenResolutionThenTheFarAway) {
  const std::pair<StageTimes, Level> all[] = {{stages(0.040, 0.005, 0.002, 0.015), Level::kEveryOther},
                                              {stages(0.100, 0.010, 0.002, 0.020), Level::kHalfResolution},
                                              {stages(0.100, 0.030, 0.010, 0.010), Level::kNear},
                                              {stages(0.400, 0.400, 0.400, 0.400), Level::kNear}};
  for (const auto& [times, level] : all) {
    FrameBudget budget = thirty_hertz();
    std::vector<Level> seen{budget.level()};
    for (int i = 0; i < 20; ++i) {
      work(budget, times, 1);
      if (budget.level() != seen.back()) seen.push_back(budget.level());
    }
    EXPECT_EQ(budget.level(), level);
    for (std::size_t i = 0; i < seen.size(); ++i)
      EXPECT_EQ(seen[i], static_cast<Level>(i)) << "in this order";
  }
}

TEST(FrameBudget, TakesNoSingleLateFrameSeriously) {
  FrameBudget budget = thirty_hertz();
  for (int i = 0; i < 100; ++i) {
    budget.took(seconds(i % 3 == 0 ? 0.010 : 0.100));
    EXPECT_EQ(budget.level(), Level::kFull);
  }
}

TEST(FrameBudget, LeavesOutOnlyWhatFollowsOnceAndNothingAtFullEffort) {
  FrameBudget budget = thirty_hertz();
  EXPECT_FALSE(budget.leaves_out(kPeriod));
  EXPECT_FALSE(budget.leaves_out(Duration(1)));
  work(budget, stages(0.060, 0, 0, 0), 3);
  ASSERT_EQ(budget.level(), Level::kEveryOther);
  EXPECT_TRUE(budget.leaves_out(kPeriod));
  EXPECT_FALSE(budget.leaves_out(2 * kPeriod)) << "the newest frame is never left out for long";
}

RC_GTEST_PROP(FrameBudget, IsAtFullEffortAgainBeforeLongWhenThereIsRoom, ()) {
  FrameBudget budget = thirty_hertz();
  for (int i = *rc::gen::inRange(0, 200); i > 0; --i) budget.took(seconds(1e-3 * *rc::gen::inRange(0, 200)));
  const FrameBudgetConfig config;
  int frames = 0;
  for (; budget.level() != Level::kFull && frames < 4 * config.longest_calm; ++frames)
    budget.took(seconds(0.010));
  RC_ASSERT(budget.level() == Level::kFull);
}

RC_GTEST_PROP(FrameBudget, MovesOneLevelAtATimeAndOnlyForAReason, ()) {
  FrameBudget budget = thirty_hertz();
  for (int i = 0; i < 300; ++i) {
    const Level before = budget.level();
    const Duration took = seconds(1e-3 * *rc::gen::inRange(0, 150)), time = budget.time();
    const bool late = budget.took(took);
    RC_ASSERT(late == (took > time));
    const int moved = static_cast<int>(budget.level()) - static_cast<int>(before);
    RC_ASSERT(moved >= -1 && moved <= 1);
    if (moved > 0) RC_ASSERT(late);
    if (moved < 0) RC_ASSERT(!late);
  }
}

RC_GTEST_PROP(FrameBudget, DoesNotSwingOnAComputerThatIsTooSlow, ()) {
  FrameBudget budget = thirty_hertz();
  const auto some = [](int most) { return 1e-3 * *rc::gen::inRange(0, most); };
  const StageTimes times = stages(some(150), some(40), some(10), some(30));
  int late = 0;
  constexpr int kFrames = 20000;  // eleven minutes
  for (int i = 0; i < kFrames; ++i) late += budget.took(at_level(times, budget.level()).total());
  if (at_level(times, Level::kNear).total() > 2 * kPeriod) return;  // nothing helps
  RC_ASSERT(late < kFrames / 100);
}

TEST(FrameBudget, ForgetsThatTryingWasInVainOnceItWasNot) {
  FrameBudget budget = thirty_hertz();
  const StageTimes slow = stages(0.100, 0.005, 0.001, 0.010), fast = stages(0.015, 0.002, 0.001, 0.005);
  work(budget, slow, 5000);
  ASSERT_GE(budget.level(), Level::kHalfResolution);
  work(budget, fast, 10000);
  ASSERT_EQ(budget.level(), Level::kFull);
  work(budget, slow, 10);
  ASSERT_EQ(budget.level(), Level::kHalfResolution);
  work(budget, fast, 70);
  EXPECT_EQ(budget.level(), Level::kFull) << "after twice thirty frames, as at first";
}

}  // namespace
}  // namespace headway::runtime
