#include "sim_hal/trapezoid.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::sim {
namespace {

double between(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 100001) / 100000.0;
}

RC_GTEST_PROP(Trapezoid, EndsAtRestOnTheTargetWithinItsLimits, ()) {
  const double v = between(0.1, 5), a = between(0.1, 20), d = between(0.1, 20);
  const double v0 = between(-5, 5), target = between(-10, 10);
  const Trapezoid t = Trapezoid::move({0, v0}, target, v, a, d);
  RC_ASSERT(t.at(t.duration() + 1).position == target);
  RC_ASSERT(t.at(t.duration() + 1).velocity == 0);
  const double top = std::max(v, std::abs(v0)), dt = t.duration() / 2000;
  for (int i = 0; i < 2000; ++i) {
    const auto before = t.at(i * dt), after = t.at((i + 1) * dt);
    RC_ASSERT(std::abs(after.velocity) <= top + 1e-9);
    RC_ASSERT(std::abs(after.velocity - before.velocity) <= std::max(a, d) * dt + 1e-9);
    RC_ASSERT(std::abs(after.position - before.position) <= top * dt + 1e-9);
  }
}

RC_GTEST_PROP(Trapezoid, TakesTheTextbookTimeFromRest, ()) {
  const double v = between(0.1, 5), a = between(0.5, 20), distance = between(0.01, 10);
  const Trapezoid t = Trapezoid::move({0, 0}, distance, v, a, a);
  const double expected = distance >= v * v / a ? distance / v + v / a : 2 * std::sqrt(distance / a);
  RC_ASSERT(std::abs(t.duration() - expected) < 1e-9);
}

RC_GTEST_PROP(Trapezoid, StopsAsSoonAsItCan, ()) {
  const double v0 = between(-5, 5), d = between(0.1, 20);
  const Trapezoid t = Trapezoid::stop({1, v0}, d);
  RC_ASSERT(std::abs(t.duration() - std::abs(v0) / d) < 1e-12);
  RC_ASSERT(std::abs(t.end() - (1 + v0 * std::abs(v0) / (2 * d))) < 1e-9);
}

TEST(Trapezoid, BrakesBeforeItTurnsBack) {
  const Trapezoid t = Trapezoid::move({0, 2}, -1, 1, 4, 4);
  EXPECT_GT(t.at(0.25).position, 0);
  EXPECT_NEAR(t.at(0.5).velocity, 0, 1e-12);
  EXPECT_EQ(t.end(), -1);
}

}  // namespace
}  // namespace headway::sim
