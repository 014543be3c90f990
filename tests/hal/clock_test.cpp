#include "hal/clock.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::hal {
namespace {

TEST(ManualClock, StandsStillUntilMoved) {
  ManualClock clock;
  EXPECT_EQ(clock.now(), Time{});
  EXPECT_EQ(clock.now(), Time{});
  clock.advance(seconds(0.005));
  EXPECT_EQ(clock.now(), at_seconds(0.005));
}

TEST(ManualClock, SleepingMovesItForwardAndNeverBack) {
  ManualClock clock;
  clock.sleep_until(at_seconds(2));
  EXPECT_EQ(clock.now(), at_seconds(2));
  clock.sleep_until(at_seconds(1));
  EXPECT_EQ(clock.now(), at_seconds(2));
}

TEST(MonotonicClock, SleepsAtLeastUntilTheTimeAskedFor) {
  MonotonicClock clock;
  const Time until = clock.now() + std::chrono::milliseconds(2);
  clock.sleep_until(until);
  EXPECT_GE(clock.now(), until);
}

TEST(MonotonicClock, ReturnsAtOnceWhenTheTimeHasPassed) {
  MonotonicClock clock;
  const Time before = clock.now();
  clock.sleep_until(before - seconds(3600));
  EXPECT_LT(clock.now() - before, seconds(60));
}

TEST(ScaledClock, RunsSlowerThanTheMachinesOwn) {
  MonotonicClock machine;
  ScaledClock clock(20);
  const Time before = machine.now();
  const Time between = clock.now();
  const Time after = machine.now();
  EXPECT_GE(to_seconds(between) * 20, to_seconds(before) - 1e-6);
  EXPECT_LE(to_seconds(between) * 20, to_seconds(after) + 1e-6);
  EXPECT_EQ(ManualClock().at_monotonic(before), before);
  EXPECT_NEAR(to_seconds(clock.at_monotonic(before)), to_seconds(before) / 20, 1e-6);
}

TEST(ScaledClock, SleepsAtLeastUntilTheTimeAskedFor) {
  ScaledClock clock(0.01);  // faster
  const Time until = clock.now() + seconds(0.2);
  clock.sleep_until(until);
  EXPECT_GE(clock.now(), until);
}

RC_GTEST_PROP(Seconds, ComeBackToTheNanosecond, (std::int32_t microseconds)) {
  const double s = microseconds * 1e-6;
  RC_ASSERT(seconds(s) == std::chrono::microseconds(microseconds));
  RC_ASSERT(std::abs(to_seconds(seconds(s)) - s) < 1e-9);
}

}  // namespace
}  // namespace headway::hal
