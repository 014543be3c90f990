#include "nav/walking/forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::nav {
namespace {

using Eigen::Vector2d;
using hal::Foot;
using hal::Footstep;
using Phase = WalkingPattern::Phase;

constexpr double kLength = 0.2172, kWidth = 0.138;

double between(double low, double high) { return low + (high - low) * *rc::gen::inRange(0, 10001) / 10000.0; }

std::vector<Footstep> random_steps(int count) {
  std::vector<Footstep> steps;
  Foot foot = *rc::gen::inRange(0, 2) == 0 ? Foot::kLeft : Foot::kRight;
  for (int i = 0; i < count; ++i, foot = other(foot)) {
    const double side = foot == Foot::kLeft ? 1 : -1;
    steps.push_back(hal::quantised(
        {foot, {between(-0.02, 0.2), side * between(0.19, 0.24), between(-0.08, 0.08)}, 0, seconds(0.8)}));
  }
  return steps;
}

std::vector<Footstep> straight(int count, double length, double duration = 0.8) {
  std::vector<Footstep> steps;
  Foot foot = Foot::kLeft;
  for (int i = 0; i < count; ++i, foot = other(foot))
    steps.push_back(hal::quantised(
        {foot, {i + 1 < count ? length : 0, foot == Foot::kLeft ? 0.19 : -0.19, 0}, 0, seconds(duration)}));
  return steps;
}

/// What the pattern generator makes of the steps, handed over as early as it takes them.
std::vector<WalkingSample> walked(const hal::Stance& start, const std::vector<Footstep>& steps) {
  WalkingPattern pattern({}, start);
  std::vector<WalkingSample> samples;
  std::size_t next = 0;
  do {
    while (next < steps.size() && pattern.queue_free() > 0 && pattern.push(steps[next])) ++next;
    pattern.begin();
    samples.push_back(pattern.tick());
  } while (pattern.phase() != Phase::kStanding);
  return samples;
}

double margin_of(const WalkingSample& s) {
  if (s.support == Support::kBoth)
    return SupportPolygon(s.left.pose, s.right.pose, kLength, kWidth).margin(s.zmp);
  return SupportPolygon(s.support == Support::kLeft ? s.left.pose : s.right.pose, kLength, kWidth)
      .margin(s.zmp);
}

RC_GTEST_PROP(WalkForecaster, ForeseesTheWalkThatIsWalkedWhateverIsCommittedByThen, ()) {
  const hal::Stance start = hal::Stance::parallel({between(-5, 5), between(-5, 5), between(-3, 3)}, 0.19);
  const int count = *rc::gen::inRange(1, 20);
  const auto steps = random_steps(count);
  const auto committed = static_cast<std::size_t>(*rc::gen::inRange(0, count + 1));
  const std::vector<WalkingSample> truth = walked(start, steps);

  WalkForecaster forecaster({}, kLength, kWidth);
  forecaster.rest_at(start);
  for (std::size_t i = 0; i < committed; ++i) RC_ASSERT(forecaster.commit(steps[i]));
  std::vector<WalkingSample> seen;
  const auto forecast =
      forecaster.foresee(std::span(steps).subspan(committed), [&](const WalkingSample& s, double margin) {
        seen.push_back(s);
        RC_ASSERT(margin == margin_of(s));
      });
  RC_ASSERT(forecast.has_value());
  RC_ASSERT(seen.size() <= truth.size());
  // A walk that is committed to its end is foreseen from the step before its last two on.
  const std::size_t before = truth.size() - seen.size();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    RC_ASSERT(seen[i].com == truth[before + i].com);
    RC_ASSERT(seen[i].zmp == truth[before + i].zmp);
    RC_ASSERT(seen[i].yaw == truth[before + i].yaw);
    least = std::min(least, margin_of(truth[before + i]));
  }
  RC_ASSERT(forecast->margin == least);
  RC_ASSERT(!forecast->step || *forecast->step < std::max<std::size_t>(1, steps.size() - committed));
}

RC_GTEST_PROP(WalkForecaster, FindsAWalkThatEndsEarlyAsSafeAsTheWholeToHalfAMillimetre, ()) {
  const auto steps = random_steps(*rc::gen::inRange(2, 16));
  WalkForecaster forecaster({}, kLength, kWidth);
  forecaster.rest_at(hal::Stance::parallel({}, 0.19));
  const double whole = forecaster.foresee(steps)->margin;
  for (std::size_t end = 1; end < steps.size(); ++end)
    RC_ASSERT(forecaster.foresee(std::span(steps).first(end))->margin >= whole - 0.0005);
}

TEST(WalkForecaster, SaysWhyAWalkShouldNotBeWalked) {
  using testing::HasSubstr;
  EXPECT_EQ(complaint(Forecast{0.05, 2}, 0.05), "");
  EXPECT_THAT(complaint(Forecast{0.004, 2}, 0.05),
              HasSubstr("would tip the robot: in step 3 the ZMP comes to 4 mm from the sole's edge, expected "
                        "50 mm or more"));
  EXPECT_THAT(complaint(Forecast{-0.01, std::nullopt}, 0.05), HasSubstr(": while coming to rest the ZMP"));
  EXPECT_THAT(complaint(std::nullopt, 0.05), HasSubstr("does not take"));
}

TEST(WalkForecaster, FindsTheRobotsOwnGaitSafe) {
  WalkForecaster forecaster({}, kLength, kWidth);
  forecaster.rest_at(hal::Stance::parallel({}, 0.19));
  const auto forecast = forecaster.foresee(straight(11, 0.2));
  ASSERT_TRUE(forecast);
  // Kajita's pattern with 0.7 s single and 0.1 s double support: at least 60 mm inside the sole.
  EXPECT_GE(forecast->margin, 0.059);
  EXPECT_LE(forecast->margin, kWidth / 2);
}

TEST(WalkForecaster, FindsWhereAHurriedWalkWouldTip) {
  WalkingConfig hurried;
  hurried.shortest_step = 0.2;
  hurried.double_support = 0.02;
  hurried.preview.window = 0.38;
  WalkForecaster forecaster(hurried, kLength, kWidth);
  forecaster.rest_at(hal::Stance::parallel({}, 0.19));
  const auto forecast = forecaster.foresee(straight(11, 0.2, 0.2));
  ASSERT_TRUE(forecast);
  EXPECT_LT(forecast->margin, 0);
  ASSERT_TRUE(forecast->step);
  EXPECT_LT(*forecast->step, 11U);
}

TEST(WalkForecaster, SaysNothingOfStepsThatThePatternDoesNotTake) {
  WalkForecaster forecaster({}, kLength, kWidth);
  forecaster.rest_at(hal::Stance::parallel({}, 0.19));
  auto steps = straight(5, 0.1);
  steps[3].foot = steps[2].foot;
  EXPECT_FALSE(forecaster.foresee(steps));
  EXPECT_FALSE(forecaster.foresee(straight(5, 0.1, 0.5)));
  EXPECT_TRUE(forecaster.commit(steps[0]));
  EXPECT_FALSE(forecaster.commit(steps[0]));
}

TEST(WalkForecaster, HasNothingToFearAtRest) {
  WalkForecaster forecaster({}, kLength, kWidth);
  forecaster.rest_at(hal::Stance::parallel({1, 2, 3}, 0.19));
  const auto forecast = forecaster.foresee({});
  ASSERT_TRUE(forecast);
  EXPECT_EQ(forecast->margin, std::numeric_limits<double>::infinity());
}

TEST(WalkForecaster, BeginsAnewWhereTheRobotRests) {
  WalkForecaster used({}, kLength, kWidth), fresh({}, kLength, kWidth);
  const hal::Stance here = hal::Stance::parallel({3, -2, 1}, 0.19);
  used.rest_at(hal::Stance::parallel({}, 0.19));
  for (const Footstep& step : straight(6, 0.2)) EXPECT_TRUE(used.commit(step));
  used.rest_at(here);
  fresh.rest_at(here);
  EXPECT_EQ(used.foresee(straight(4, 0.15))->margin, fresh.foresee(straight(4, 0.15))->margin);
}

}  // namespace
}  // namespace headway::nav
