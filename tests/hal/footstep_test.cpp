#include "hal/footstep.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/bus_codec.h"
#include "hal/step_number.h"
#include "hal/walker.h"

namespace headway::hal {
namespace {

Footstep any_step() {
  const auto between = [](int lo, int hi, double unit) { return *rc::gen::inRange(lo, hi) * unit; };
  return {*rc::gen::element(Foot::kLeft, Foot::kRight),
          {between(-700000, 700000, 1e-6), between(-700000, 700000, 1e-6), between(-400000, 400000, 1e-6)},
          between(-200000, 200000, 1e-6),
          std::chrono::milliseconds(*rc::gen::inRange(-100, 2000)),
          between(-20000, 200000, 1e-6)};
}

bool same(const Footstep& a, const Footstep& b) {
  return a.foot == b.foot && a.landing.x == b.landing.x && a.landing.y == b.landing.y &&
         a.landing.yaw == b.landing.yaw && a.dz == b.dz && a.duration == b.duration && a.clear == b.clear;
}

bus::StepCommand as_message(const Footstep& s) {
  return {.foot = static_cast<bus::StepCommand::Foot>(s.foot),
          .clear = s.clear,
          .dx = s.landing.x,
          .dy = s.landing.y,
          .dtheta = s.landing.yaw,
          .duration = to_seconds(s.duration),
          .dz = s.dz};
}

RC_GTEST_PROP(QuantisedStep, IsWhatTheBusCarriesBitForBit, ()) {
  const bus::StepCommand sent = as_message(quantised(any_step()));
  const auto frame = sent.pack();
  RC_ASSERT(frame.has_value());
  const auto received = bus::StepCommand::unpack(*frame);
  RC_ASSERT(received.has_value());
  RC_ASSERT(received->dx == sent.dx);
  RC_ASSERT(received->dy == sent.dy);
  RC_ASSERT(received->dtheta == sent.dtheta);
  RC_ASSERT(received->dz == sent.dz);
  RC_ASSERT(std::abs(received->duration - sent.duration) < 1e-12);
}

RC_GTEST_PROP(QuantisedStep, IsQuantisedAlready, ()) {
  const Footstep q = quantised(any_step());
  RC_ASSERT(same(quantised(q), q));
}

RC_GTEST_PROP(QuantisedStep, LiesWithinHalfAUnitOfAnyStepInReach, ()) {
  Footstep s = any_step();
  s.landing.x = std::clamp(s.landing.x, -0.5, 0.5);
  s.landing.y = std::clamp(s.landing.y, -0.5, 0.5);
  s.landing.yaw = std::clamp(s.landing.yaw, -0.25, 0.25);
  s.dz = std::clamp(s.dz, -0.12, 0.12);
  const Footstep q = quantised(s);
  RC_ASSERT(std::abs(q.landing.x - s.landing.x) <= 0.5e-3 + 1e-12);
  RC_ASSERT(std::abs(q.landing.y - s.landing.y) <= 0.5e-3 + 1e-12);
  RC_ASSERT(std::abs(q.landing.yaw - s.landing.yaw) <= 1e-3 + 1e-12);
  RC_ASSERT(std::abs(q.dz - s.dz) <= 4e-3 + 1e-12);
}

TEST(Stance, MovesOnlyTheSwingingFoot) {
  const Stance start = Stance::parallel({1, 1, std::numbers::pi / 2}, 0.2);
  const Stance next = start.after({.foot = Foot::kLeft, .landing = {0.2, 0.2, 0.1}});
  EXPECT_EQ(next.right.x, start.right.x);
  EXPECT_NEAR(next.left.x, 1 + 0.1 - 0.2, 1e-12);
  EXPECT_NEAR(next.left.y, 1 + 0.2, 1e-12);
  EXPECT_NEAR(next.left.yaw, std::numbers::pi / 2 + 0.1, 1e-12);
}

RC_GTEST_PROP(Stance, BaseOfParallelFeetIsWhereTheyWerePut, ()) {
  const Pose2 base{*rc::gen::inRange(-5000, 5000) * 1e-3, *rc::gen::inRange(-5000, 5000) * 1e-3,
                   *rc::gen::inRange(-3141, 3141) * 1e-3};
  const Pose2 back = Stance::parallel(base, 0.19).base();
  RC_ASSERT((back.position() - base.position()).norm() < 1e-9);
  RC_ASSERT(std::abs(wrap_angle(back.yaw - base.yaw)) < 1e-9);
}

RC_GTEST_PROP(StepNumber, ComesBackFromTheWireForTheLast64Steps, ()) {
  const std::uint32_t newest = *rc::gen::inRange(0u, 100000u);
  const std::uint32_t back = *rc::gen::inRange(0u, kStepNumbers);
  RC_PRE(back <= newest);
  RC_ASSERT(unwrapped(wire_number(newest - back), newest) == newest - back);
}

TEST(StepNumber, IsNothingForNoneAndForNumbersBeforeTheFirstStep) {
  EXPECT_FALSE(unwrapped(kNoStep, 5));
  EXPECT_FALSE(unwrapped(64, 100));
  EXPECT_FALSE(unwrapped(6, 5));
  EXPECT_EQ(unwrapped(63, 64), 63u);
  EXPECT_EQ(unwrapped(0, 64), 64u);
  EXPECT_EQ(unwrapped(0, 63), 0u);
}

}  // namespace
}  // namespace headway::hal
