#include "drivers/joint_ramp.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "sim_hal/trapezoid.h"

namespace headway::drivers {
namespace {

constexpr double kPeriod = 0.02, kTiny = 1e-6;

JointRamp::Limits any_limits() {
  return {.velocity = *rc::gen::inRange(1'000, 200'000) * 1.0,
          .acceleration = *rc::gen::inRange(1'000, 1'000'000) * 1.0,
          .period = kPeriod};
}

RC_GTEST_PROP(JointRamp, KeepsItsLimitsAndTheRangeOfItsTargetsHoweverTheseChange, ()) {
  const JointRamp::Limits limits = any_limits();
  JointRamp ramp(limits);
  double target = 0, lowest = 0, highest = 0;
  for (int i = 0; i < 300; ++i) {
    if (*rc::gen::inRange(0, 20) == 0) target = *rc::gen::inRange(-45'000, 45'001);
    lowest = std::min(lowest, target);
    highest = std::max(highest, target);
    const double before = ramp.velocity();
    *rc::gen::inRange(0, 30) == 0 ? ramp.step_to_rest() : ramp.step_towards(target);
    const double change = limits.acceleration * kPeriod * kPeriod;
    RC_ASSERT(std::abs(ramp.velocity()) <= limits.velocity * kPeriod + kTiny);
    RC_ASSERT(std::abs(ramp.velocity() - before) <= change + kTiny);
    RC_ASSERT(ramp.position() >= lowest - change / 8 - kTiny);
    RC_ASSERT(ramp.position() <= highest + change / 8 + kTiny);
  }
}

RC_GTEST_PROP(JointRamp, ComesToRestExactlyAtItsTargetAboutAsSoonAsItCan, ()) {
  const JointRamp::Limits limits = any_limits();
  const double target = *rc::gen::inRange(-45'000, 45'001);
  JointRamp ramp(limits);
  int steps = 0;
  while ((ramp.position() != target || ramp.velocity() != 0) && steps < 10'000) {
    ramp.step_towards(target);
    ++steps;
    RC_ASSERT(std::abs(ramp.position()) <= std::abs(target) + kTiny);
  }
  const double best =
      sim::Trapezoid::move({0, 0}, target, limits.velocity, limits.acceleration, limits.acceleration)
          .duration();
  RC_ASSERT(steps * kPeriod <= 1.07 * best + 5 * kPeriod);
}

RC_GTEST_PROP(JointRamp, IsOnTheSameWayHoweverItsTimeIsCut, ()) {
  const JointRamp::Limits limits = any_limits();
  const double target = *rc::gen::inRange(-45'000, 45'001);
  JointRamp whole(limits), cut(limits);
  for (int step = 0; step < 200; ++step) {
    const double from = whole.position();
    whole.step_towards(target);
    // Eighths are exact, so that each step ends where it should.
    for (int left = 8; left > 0;) {
      const int part = *rc::gen::inRange(1, left + 1);
      cut.step_towards(target, part / 8.0);
      left -= part;
      RC_ASSERT(std::abs(cut.position() - (from + (8 - left) / 8.0 * whole.velocity())) < kTiny);
    }
  }
}

TEST(JointRamp, BrakesToRestOnTheShortestWay) {
  JointRamp ramp({.velocity = 50'000, .acceleration = 100'000, .period = kPeriod});
  for (int i = 0; i < 100; ++i) ramp.step_towards(1'000'000);
  ASSERT_EQ(ramp.velocity(), 1000);
  const double from = ramp.position();
  for (int i = 0; i < 26; ++i) ramp.step_to_rest();
  EXPECT_EQ(ramp.velocity(), 0);
  EXPECT_NEAR(ramp.position() - from, 12'000, 500);  // v^2 / 2a, and half a step
}

}  // namespace
}  // namespace headway::drivers
