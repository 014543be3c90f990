#include "nav/walking/walking_pattern.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d;
using hal::Foot;
using hal::Footstep;
using Phase = WalkingPattern::Phase;

constexpr double kPeriod = 0.005;

double between(double low, double high) { return low + (high - low) * *rc::gen::inRange(0, 10001) / 10000.0; }

hal::Stance random_start() {
  return hal::Stance::parallel({between(-5, 5), between(-5, 5), between(-3, 3)}, 0.19);
}

/// Alternating steps as the planner makes them, as they travel.
std::vector<Footstep> random_steps(int count) {
  std::vector<Footstep> steps;
  Foot foot = *rc::gen::inRange(0, 2) == 0 ? Foot::kLeft : Foot::kRight;
  for (int i = 0; i < count; ++i) {
    const double side = foot == Foot::kLeft ? 1 : -1;
    const Footstep step{foot,
                        {between(-0.05, 0.2), side * between(0.19, 0.24), between(-0.087, 0.087)},
                        0,
                        seconds(between(0.8, 1.0))};
    Footstep wire = hal::quantised(step);
    wire.duration = std::max(wire.duration, seconds(0.8));
    steps.push_back(wire);
    foot = other(foot);
  }
  return steps;
}

enum class Feed { kEarly, kJustInTime };

bool wants_step(const WalkingPattern& pattern, Feed feed) {
  return feed == Feed::kEarly ? pattern.queue_free() > 0 : pattern.wants_step();
}

/// Feeds steps and ticks until the robot stands again.
std::vector<WalkingSample> walk(WalkingPattern& pattern, const std::vector<Footstep>& steps,
                                Feed feed = Feed::kEarly) {
  std::vector<WalkingSample> samples{pattern.sample()};
  std::size_t next = 0;
  do {
    while (next < steps.size() && wants_step(pattern, feed) && pattern.push(steps[next])) ++next;
    if (pattern.started() == 0) pattern.begin();
    samples.push_back(pattern.tick());
  } while (pattern.phase() != Phase::kStanding && samples.size() < 100000);
  return samples;
}

RC_GTEST_PROP(WalkingPattern, LandsExactlyWhereTheChainOfFootstepsLeads, ()) {
  const hal::Stance start = random_start();
  const auto steps = random_steps(*rc::gen::inRange(1, 20));
  WalkingPattern pattern({}, start);
  walk(pattern, steps);
  hal::Stance expected = start;
  for (const Footstep& s : steps) expected = expected.after(s);
  for (const Foot f : {Foot::kLeft, Foot::kRight}) {
    RC_ASSERT(pattern.sample().at(f).pose.position() == expected.at(f).position());
    RC_ASSERT(pattern.sample().at(f).pose.yaw == expected.at(f).yaw);
    RC_ASSERT(pattern.sample().at(f).z == 0);
  }
  RC_ASSERT(pattern.sample().landed == steps.size());
  RC_ASSERT((pattern.sample().com - expected.base().position()).norm() <= pattern.config().settled_distance);
}

RC_GTEST_PROP(WalkingPattern, MovesOneFootAtATimeAndNeverJumps, ()) {
  WalkingPattern pattern({}, random_start());
  const auto samples = walk(pattern, random_steps(*rc::gen::inRange(1, 10)));
  double highest = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const WalkingSample &a = samples[i - 1], &b = samples[i];
    for (const Foot f : {Foot::kLeft, Foot::kRight}) {
      const bool stands =
          b.support == Support::kBoth || b.support == (f == Foot::kLeft ? Support::kLeft : Support::kRight);
      const Vector2d moved = b.at(f).pose.position() - a.at(f).pose.position();
      if (stands && a.support != Support::kBoth && b.support == Support::kBoth) continue;  // touches down
      if (stands) RC_ASSERT(moved.norm() == 0);
      RC_ASSERT(moved.norm() < 1.5 * kPeriod);
      RC_ASSERT((b.at(f).z > 0) == !stands);
      highest = std::max(highest, b.at(f).z);
    }
    RC_ASSERT((b.com - a.com).norm() < 0.7 * kPeriod);
    RC_ASSERT(std::abs(wrap_angle(b.yaw - a.yaw)) < 0.5 * kPeriod);
  }
  RC_ASSERT(std::abs(highest - 0.07) < 1e-3);
}

RC_GTEST_PROP(WalkingPattern, KeepsTheZmpOnTheSoleThatStands, ()) {
  WalkingPattern pattern({}, random_start());
  for (const WalkingSample& s : walk(pattern, random_steps(*rc::gen::inRange(1, 15)))) {
    if (s.support == Support::kBoth) continue;
    const Pose2& sole = s.support == Support::kLeft ? s.left.pose : s.right.pose;
    const Vector2d off = sole.inverse() * s.zmp;
    RC_ASSERT(std::abs(off.x()) < 0.1086 - 0.06);
    RC_ASSERT(std::abs(off.y()) < 0.069 - 0.05);
  }
}

/// The reason for the length of the window: what is known early must not matter.
RC_GTEST_PROP(WalkingPattern, MovesTheSameWhetherStepsComeEarlyOrJustInTime, ()) {
  const hal::Stance start = random_start();
  const auto steps = random_steps(*rc::gen::inRange(4, 16));
  WalkingPattern early({}, start), late({}, start);
  const auto a = walk(early, steps, Feed::kEarly), b = walk(late, steps, Feed::kJustInTime);
  RC_ASSERT(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    RC_ASSERT(a[i].com == b[i].com);
    RC_ASSERT(a[i].left.pose.position() == b[i].left.pose.position());
  }
}

/// The same, some of them higher and longer, over something, and up or down.
std::vector<Footstep> random_steps_over(int count) {
  std::vector<Footstep> steps = random_steps(count);
  for (Footstep& s : steps) {
    if (*rc::gen::inRange(0, 3) == 0) continue;
    s.landing.x = between(-0.05, 0.45);
    s.clear = between(0.02, 0.14);
    s.dz = between(-0.04, 0.04);
    s.duration = seconds(between(1.2, 1.55));
    s = hal::quantised(s);
  }
  return steps;
}

/// Heights of both soles, by Foot [m].
struct Heights {
  double left = 0, right = 0;
  double& of(Foot f) { return f == Foot::kLeft ? left : right; }
};

RC_GTEST_PROP(WalkingPattern, ClearsWhatItStepsOverWhileTheSoleIsOnItsWay, ()) {
  hal::Stance stance = random_start();
  const auto steps = random_steps_over(*rc::gen::inRange(1, 10));
  WalkingPattern pattern({}, stance);
  const auto samples = walk(pattern, steps);
  Heights stood, planned;  // before the step in hand, and after it
  std::size_t sample = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Footstep& step = steps[i];
    const hal::Stance after = stance.after(step);
    planned.of(step.foot) = stood.of(hal::other(step.foot)) + step.dz;
    const double higher = std::max({stood.left, stood.right, planned.of(step.foot)});
    const Vector2d way = after.at(step.foot).position() - stance.at(step.foot).position();
    bool on_its_way = false;
    for (; sample < samples.size() && samples[sample].landed <= i; ++sample) {
      const FootPose& foot = samples[sample].at(step.foot);
      const double moved = (foot.pose.position() - stance.at(step.foot).position()).norm() / way.norm();
      if (step.clear == 0 || way.norm() < 0.05 || moved < 0.02 || moved > 0.98) continue;
      on_its_way = true;
      RC_ASSERT(foot.z > higher + step.clear);
    }
    RC_ASSERT(on_its_way || step.clear == 0 || way.norm() < 0.05);
    RC_ASSERT(samples[std::min(sample, samples.size() - 1)].at(step.foot).pose.position() ==
              after.at(step.foot).position());
    RC_ASSERT(std::abs(samples[std::min(sample, samples.size() - 1)].at(step.foot).z -
                       planned.of(step.foot)) < 1e-12);
    stance = after;
    stood = planned;
  }
  RC_ASSERT(samples.back().landed == steps.size());
  for (std::size_t i = 1; i < samples.size(); ++i)
    for (const Foot f : {Foot::kLeft, Foot::kRight})
      RC_ASSERT(std::abs(samples[i].at(f).z - samples[i - 1].at(f).z) < 1.5 * kPeriod);
}

TEST(WalkingPattern, ClosesWhenAStepIsNotKnownThatHasToBe) {
  const WalkingConfig config;
  const auto step = [](std::uint32_t i) {
    return Footstep{i % 2 == 0 ? Foot::kLeft : Foot::kRight, {0.1, i % 2 == 0 ? 0.19 : -0.19, 0}};
  };
  const double shift = config.preview.window + config.double_support;
  for (std::uint32_t count = 1; count < 6; ++count) {
    WalkingPattern pattern(config, hal::Stance::parallel({}, 0.19));
    for (std::uint32_t i = 0; i < count; ++i) ASSERT_TRUE(pattern.push(step(i)));
    pattern.begin();
    // 0.3 s after the lift-off of the step two before; of the second step, as if there were one.
    const double until = shift + 0.8 * (static_cast<double>(count) - 2) + 0.3;
    int ticks = 0;
    for (; !pattern.closed(); ++ticks) pattern.tick();
    EXPECT_NEAR(ticks * kPeriod, until, 1e-9);
    EXPECT_FALSE(pattern.push(step(count)));
    while (pattern.phase() != Phase::kStanding) pattern.tick();
    EXPECT_EQ(pattern.sample().landed, count);
  }
}

RC_GTEST_PROP(WalkingPattern, RestsSoonAfterAnAbortAtAnyTime, ()) {
  WalkingPattern pattern({}, random_start());
  std::vector<Footstep> steps = random_steps(14);
  for (Footstep& s : steps) s.duration = seconds(0.8);
  std::size_t next = 0;
  const int abort_at = *rc::gen::inRange(0, 1800);
  for (int tick = 0; tick < abort_at; ++tick) {
    while (next < steps.size() && pattern.push(steps[next])) ++next;
    pattern.begin();
    pattern.tick();
  }
  const auto started = pattern.started();
  pattern.abort();
  int ticks = 0;
  for (; pattern.phase() != Phase::kStanding; ++ticks) {
    pattern.tick();
    const WalkingSample& s = pattern.sample();
    RC_ASSERT((s.zmp - s.zmp_reference).norm() < 0.012);
  }
  RC_ASSERT(ticks * kPeriod <= 2.7 + 1e-9);
  RC_ASSERT(pattern.sample().landed <= started + 2);
  const hal::Stance feet{pattern.sample().left.pose, pattern.sample().right.pose};
  RC_ASSERT((feet.base().position() - pattern.planned_stance().base().position()).norm() == 0);
}

RC_GTEST_PROP(WalkingPattern, WalksAgainFromWhereItStands, ()) {
  const hal::Stance start = random_start();
  WalkingPattern pattern({}, start);
  hal::Stance expected = start;
  for (int n = 0; n < 3; ++n) {
    const auto steps = random_steps(*rc::gen::inRange(1, 6));
    for (const Footstep& s : steps) expected = expected.after(s);
    pattern.reopen();
    for (const WalkingSample& s : walk(pattern, steps)) RC_ASSERT((s.zmp - s.zmp_reference).norm() < 0.012);
  }
  RC_ASSERT(pattern.sample().left.pose.position() == expected.left.position());
  RC_ASSERT(pattern.sample().right.pose.position() == expected.right.position());
}

/// Where the body may come to a halt without a further step: Pratt et al., "Capture point", 2006.
Vector2d capture_point(const WalkingSample& sample) {
  return sample.com + sample.com_velocity * std::sqrt(PreviewConfig{}.com_height / 9.81);
}

/// Steps as long, wide and turned as they may be, or as little, come in all orders of three.
TEST(WalkingPattern, SettlesWithinThreeTenthsOfASecond) {
  constexpr unsigned kSteps = 3, kBits = 3, kOrders = 1U << (kSteps * kBits);
  int most = 0;
  for (unsigned order = 0; order < kOrders; ++order) {
    WalkingPattern pattern({}, hal::Stance::parallel({}, 0.19));
    Foot foot = Foot::kLeft;
    for (unsigned i = 0; i < kSteps; ++i, foot = other(foot)) {
      const auto most_of = [&](unsigned bit) { return (order >> (kBits * i + bit) & 1) != 0; };
      const double aside = most_of(1) ? 0.24 : 0.19;
      ASSERT_TRUE(pattern.push(
          {foot,
           {most_of(0) ? 0.2 : -0.05, foot == Foot::kLeft ? aside : -aside, most_of(2) ? 0.087 : -0.087}}));
    }
    pattern.begin();
    while (pattern.phase() == Phase::kWalking) pattern.tick();
    int ticks = 0;
    for (; pattern.phase() == Phase::kSettling; ++ticks) pattern.tick();
    most = std::max(most, ticks);
    const WalkingSample& s = pattern.sample();
    const Vector2d middle = (s.left.pose.position() + s.right.pose.position()) / 2;
    ASSERT_LE((capture_point(s) - middle).norm(), 0.002) << "what still moves needs no step to come to rest";
    ASSERT_LE((s.zmp - middle).norm(), 0.0025);
  }
  EXPECT_LE(most * kPeriod, 0.3);
  EXPECT_GE(most * kPeriod, 0.2) << "or there was nothing to settle";
}

TEST(WalkingPattern, RefusesStepsItCannotWalk) {
  WalkingPattern pattern({}, hal::Stance::parallel({}, 0.19));
  const Footstep left{Foot::kLeft, {0.1, 0.19, 0}}, right{Foot::kRight, {0.1, -0.19, 0}};
  Footstep hurried = right;
  hurried.duration = seconds(0.75);
  EXPECT_TRUE(pattern.push(left));
  EXPECT_FALSE(pattern.push(left)) << "the same foot twice";
  EXPECT_FALSE(pattern.push(hurried));
  for (std::size_t i = 1; i < WalkingPattern::kQueue; ++i)
    EXPECT_TRUE(pattern.push(i % 2 == 1 ? right : left));
  EXPECT_EQ(pattern.queue_free(), 0U);
  EXPECT_FALSE(pattern.push(left)) << "full";
}

TEST(WalkingPattern, RefusesAWindowLongerThanWhatIsKnown) {
  WalkingConfig config;
  config.preview.window = 1.6;
  EXPECT_THROW(WalkingPattern(config, hal::Stance::parallel({}, 0.19)), InputError);
  config.double_support = 0.02;
  config.preview.window = 1.58;
  EXPECT_NO_THROW(WalkingPattern(config, hal::Stance::parallel({}, 0.19)));
}

}  // namespace
}  // namespace headway::nav
