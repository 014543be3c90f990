#include "sim_hal/body.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"

namespace headway::sim {
namespace {

using Eigen::Vector2d;
using hal::Foot;
using hal::Footstep;
using nav::WalkingPattern;

constexpr double kPeriod = 0.005;

double between(double low, double high) { return low + (high - low) * *rc::gen::inRange(0, 10001) / 10000.0; }

/// One random step of a kind of walk: 0 straight on, 1 turning, 2 sideways, 3 anything within the limits, 4
/// on the spot.
Footstep random_step(int kind, Foot foot, int number) {
  const double side = foot == Foot::kLeft ? 1 : -1;
  const bool outward = number % 2 == 0;
  switch (kind) {
    case 0:
      return {foot, {0.2, side * 0.19, 0}};
    case 1:
      return {foot, {between(0, 0.15), side * 0.19, side * (outward ? 0.087 : 0)}};
    case 2:
      return {foot, {0, side * (outward ? 0.24 : 0.19), 0}};
    case 3:
      return {foot, {between(-0.05, 0.2), side * between(0.19, 0.24), between(-0.087, 0.087)}};
    default:
      return {foot, {0, side * 0.19, 0}};
  }
}

struct Walked {
  bool fell = false;
  double margin = 1;
  std::uint32_t landed = 0;
  double base_error = 0;  ///< between true and believed base at the end [m]
};

/// Walks up to `count` steps of `kind`, ended early by an abort at tick `abort_at`.
Walked walk(int kind, int count, int abort_at, std::uint64_t seed) {
  WalkingPattern pattern({}, hal::Stance::parallel({1, 2, 0.5}, 0.19));
  Body body({.seed = seed}, pattern.sample());
  Foot foot = seed % 2 == 0 ? Foot::kLeft : Foot::kRight;
  int pushed = 0;
  for (int tick = 0; tick < 80000; ++tick) {
    while (pushed < count && pattern.push(hal::quantised(random_step(kind, foot, pushed)))) {
      foot = other(foot);
      ++pushed;
    }
    pattern.begin();
    if (tick == abort_at) pattern.abort();
    body.tick(pattern.tick(), kPeriod);
    if (body.fallen() || (pattern.phase() == WalkingPattern::Phase::kStanding && tick > 0)) break;
  }
  const hal::Stance believed{pattern.sample().left.pose, pattern.sample().right.pose};
  return {body.fallen(), body.smallest_margin(), pattern.sample().landed,
          (body.stance().base().position() - believed.base().position()).norm()};
}

RC_GTEST_PROP(Body, NeverFallsWithinTheGaitsLimits, ()) {
  const int kind = *rc::gen::inRange(0, 5), count = *rc::gen::inRange(1, 20);
  const int abort_at = *rc::gen::inRange(0, 3) == 0 ? *rc::gen::inRange(1, 3000) : -1;
  const Walked w = walk(kind, count, abort_at, static_cast<std::uint64_t>(*rc::gen::inRange(0, 1000000)));
  RC_ASSERT(!w.fell);
  RC_ASSERT(w.margin > 0.03);
}

TEST(Body, KeepsItsBalanceOverHundredsOfSteps) {
  for (int kind = 0; kind < 5; kind += 2) {
    const Walked w = walk(kind, 300, -1, 7);
    EXPECT_FALSE(w.fell) << "walk " << kind;
    EXPECT_EQ(w.landed, 300U);
    EXPECT_GT(w.margin, 0.03);
    RecordProperty("smallest_margin_mm_" + std::to_string(kind), std::to_string(w.margin * 1e3));
  }
}

struct Strides {
  bool fell = false;
  double margin = 0;
};
Strides stride(double length, const BodyConfig& config = {}) {
  WalkingPattern pattern({}, hal::Stance::parallel({}, 0.19));
  Body body(config, pattern.sample());
  Foot foot = Foot::kLeft;
  for (int tick = 0; tick < 2000 && !body.fallen(); ++tick) {
    while (pattern.pushed() < 8 && pattern.push({foot, {length, foot == Foot::kLeft ? 0.19 : -0.19, 0}}))
      foot = other(foot);
    pattern.begin();
    body.tick(pattern.tick(), kPeriod);
  }
  return {body.fallen(), body.smallest_margin()};
}

TEST(Body, FallsFromStepsBeyondItsReach) {
  EXPECT_TRUE(stride(0.45).fell);
  EXPECT_TRUE(stride(0.40).fell);
  EXPECT_FALSE(stride(0.20).fell);
}

TEST(Body, FallsWhenItsLagOrItsHeightIsFarFromTheModel) {
  EXPECT_TRUE(stride(0.20, {.lag = 0.06}).fell);
  EXPECT_TRUE(stride(0.20, {.com_height = 1.6}).fell);
}

TEST(Body, StaysWhereItFell) {
  WalkingPattern pattern({}, hal::Stance::parallel({}, 0.19));
  Body body({.lag = 0.06}, pattern.sample());
  for (const Footstep& s : {Footstep{Foot::kLeft, {0.2, 0.19, 0}}, Footstep{Foot::kRight, {0.2, -0.19, 0}},
                            Footstep{Foot::kLeft, {0.2, 0.19, 0}}})
    pattern.push(s);
  pattern.begin();
  while (!body.fallen()) body.tick(pattern.tick(), kPeriod);
  const Eigen::Isometry3d fell_at = body.map_from_chest();
  for (int i = 0; i < 100; ++i) body.tick(pattern.tick(), kPeriod);
  EXPECT_TRUE(body.map_from_chest().isApprox(fell_at));
  EXPECT_TRUE(body.fallen());
}

TEST(Body, IsWhereItIsBelievedToBeWhenNothingIsWrong) {
  WalkingPattern pattern({}, hal::Stance::parallel({3, -1, 2}, 0.19));
  const BodyConfig ideal{.com_height = 0.814, .lag = 0, .landing_sigma = 0, .landing_yaw_sigma = 0};
  Body body(ideal, pattern.sample());
  Foot foot = Foot::kRight;
  double largest = 0;
  for (int tick = 0; tick < 1500; ++tick) {
    while (pattern.pushed() < 6 && pattern.push(random_step(0, foot, 0))) foot = other(foot);
    pattern.begin();
    const nav::WalkingSample& s = pattern.tick();
    body.tick(s, kPeriod);
    largest = std::max(largest, (body.com() - s.com).norm());
    EXPECT_NEAR(wrap_angle(body.yaw() - s.yaw), 0, 1e-9);
  }
  EXPECT_LT(largest, 1e-9);
  EXPECT_NEAR(body.path_walked(), 1.1, 1e-9) << "six strides of 0.2 m, the first from parallel feet";
}

/// The integrator's ZMP against the model's own, which it does not share.
TEST(Body, FindsTheModelsZmpByItself) {
  WalkingPattern pattern({}, hal::Stance::parallel({}, 0.19));
  const BodyConfig ideal{.com_height = 0.814, .lag = 0, .landing_sigma = 0, .landing_yaw_sigma = 0};
  Body body(ideal, pattern.sample());
  Foot foot = Foot::kLeft;
  Vector2d before = pattern.sample().zmp, before_that = before;
  for (int tick = 0; tick < 1500; ++tick) {
    while (pattern.pushed() < 5 && pattern.push(random_step(0, foot, 0))) foot = other(foot);
    pattern.begin();
    const Vector2d now = pattern.tick().zmp;
    body.tick(pattern.sample(), kPeriod);
    // The second difference is the mean acceleration of the two periods around the tick before.
    const Vector2d low = before.cwiseMin(before_that).cwiseMin(now),
                   high = before.cwiseMax(before_that).cwiseMax(now);
    EXPECT_GE((body.zmp() - low).minCoeff(), -1e-3);
    EXPECT_GE((high - body.zmp()).minCoeff(), -1e-3);
    before_that = before;
    before = now;
  }
}

TEST(Body, DriftsAsItIsTold) {
  const auto end = [](const BodyConfig& config) {
    WalkingPattern pattern({}, hal::Stance::parallel({}, 0.19));
    Body body(config, pattern.sample());
    Foot foot = Foot::kLeft;
    for (int tick = 0; tick < 10000; ++tick) {
      while (pattern.pushed() < 40 && pattern.push(random_step(0, foot, 0))) foot = other(foot);
      pattern.begin();
      body.tick(pattern.tick(), kPeriod);
    }
    return body.stance().base();
  };
  const BodyConfig exact{.landing_sigma = 0, .landing_yaw_sigma = 0};
  BodyConfig long_strides = exact, turning = exact;
  long_strides.stride_scale = 1.02;
  turning.yaw_per_step = 0.002;
  EXPECT_NEAR(end(exact).x, 7.9, 1e-6);
  EXPECT_NEAR(end(long_strides).x, 7.9 * 1.02, 1e-6);
  EXPECT_NEAR(end(turning).yaw, 40 * 0.002 - 0.001, 1e-6);
}

TEST(Body, MovesSmoothlyWhileItMovesOnToWhereTheFootReallyStands) {
  WalkingPattern pattern({}, hal::Stance::parallel({}, 0.19));
  Body body({.landing_sigma = 0.004}, pattern.sample());
  Foot foot = Foot::kLeft;
  Eigen::Isometry3d before = body.map_from_chest();
  for (int tick = 0; tick < 3000; ++tick) {
    while (pattern.pushed() < 12 && pattern.push(random_step(0, foot, 0))) foot = other(foot);
    pattern.begin();
    body.tick(pattern.tick(), kPeriod);
    const Eigen::Isometry3d now = body.map_from_chest();
    EXPECT_LT((now.translation() - before.translation()).norm(), 0.7 * kPeriod);
    EXPECT_LT(Eigen::AngleAxisd(before.linear().transpose() * now.linear()).angle(), 0.5 * kPeriod);
    before = now;
  }
}

TEST(Body, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const Walked a = walk(0, 10, -1, 3), b = walk(0, 10, -1, 3), c = walk(0, 10, -1, 5);
  EXPECT_EQ(a.margin, b.margin);
  EXPECT_EQ(a.base_error, b.base_error);
  EXPECT_NE(a.base_error, c.base_error);
}

TEST(Body, RefusesAConfigurationThatCannotBe) {
  EXPECT_THROW(BodyConfig{.com_height = 0}.validate(), InputError);
  EXPECT_THROW(BodyConfig{.lag = 1}.validate(), InputError);
  EXPECT_THROW(BodyConfig{.correction_time = 0}.validate(), InputError);
}

}  // namespace
}  // namespace headway::sim
