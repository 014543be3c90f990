#include "sim_hal/control_computer.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/sim_hal/walk_bench.h"

namespace headway::sim {
namespace {

using State = bus::WalkStatus::State;
using Reject = bus::WalkStatus::RejectReason;
using Request = bus::WalkControl::Request;
using hal::Foot;

TEST(ControlComputer, ReportsInItsRhythmsWithCountersAndCrcs) {
  WalkBench bench;
  bench.run(2.01);
  EXPECT_EQ(bench.master.statuses, 100);
  EXPECT_EQ(bench.master.times.size(), 2U);
  EXPECT_EQ(bench.master.times[1].ms - bench.master.times[0].ms, 1000U);
  for (const std::uint16_t id : {std::uint16_t{0x130}, std::uint16_t{0x131}, std::uint16_t{0x132}}) {
    bus::ProtectionChecker checker(id);
    for (const auto& f : bench.master.frames)
      if (f.id == id) {
        EXPECT_EQ(checker.check(f), bus::Check::kOk);
      }
    EXPECT_EQ(checker.counts().ok, 100U);
  }
}

TEST(ControlComputer, PairsTheChestFramesBySample) {
  WalkBench bench({}, {1.5, -2.25, 0.7});
  bench.run(0.51);
  ASSERT_EQ(bench.master.chest_xy.size(), 25U);
  ASSERT_EQ(bench.master.chest_zrot.size(), 25U);
  for (std::size_t i = 0; i < 25; ++i) {
    EXPECT_EQ(bench.master.chest_xy[i].sample, i % 16);
    EXPECT_EQ(bench.master.chest_zrot[i].sample, i % 16);
  }
  EXPECT_NEAR(bench.master.chest_xy[0].x, 1.5, 5e-4);
  EXPECT_NEAR(bench.master.chest_xy[0].y, -2.25, 5e-4);
  EXPECT_NEAR(bench.master.chest_zrot[0].z, 1.0, 5e-4);
  EXPECT_NEAR(bench.master.chest_zrot[0].yaw, 0.7, 5e-5);
}

TEST(ControlComputer, OpensASessionOnlyForANewNumberThatAsksToWalk) {
  WalkBench bench;
  bench.master.send_control(3, Request::kNone);
  bench.run(0.05);
  EXPECT_EQ(bench.master.status.session, 0);
  bench.begin(3);
  EXPECT_EQ(bench.master.status.session, 3);
  EXPECT_EQ(bench.master.status.seq_accepted, 255);
  EXPECT_EQ(bench.master.status.seq_executing, 255);
  EXPECT_EQ(bench.master.status.state, State::kStanding);
  EXPECT_EQ(bench.master.status.queue_free, 8);
}

RC_GTEST_PROP(ControlComputer, BelievesExactlyTheChainOfTheStepsThatTravelled, ()) {
  const auto between = [](double a, double b) { return a + (b - a) * *rc::gen::inRange(0, 1001) / 1000.0; };
  WalkBench bench({}, {between(-9, 9), between(-9, 9), between(-3, 3)});
  std::vector<hal::Footstep> steps;
  hal::Stance expected = bench.start_stance;
  Foot foot = *rc::gen::inRange(0, 2) == 0 ? Foot::kLeft : Foot::kRight;
  const int count = *rc::gen::inRange(1, 9);
  for (int i = 0; i < count; ++i, foot = other(foot)) {
    const double side = foot == Foot::kLeft ? 1 : -1;
    steps.push_back(
        hal::quantised({foot, {between(0, 0.2), side * between(0.19, 0.24), between(-0.087, 0.087)}}));
    expected = expected.after(steps.back());
  }
  bench.begin(1);
  RC_ASSERT(bench.walk(steps));
  bench.run(2);
  const nav::WalkingSample& s = bench.control.walking();
  RC_ASSERT(s.left.pose.position() == expected.left.position());
  RC_ASSERT(s.right.pose.position() == expected.right.position());
  RC_ASSERT(std::abs(bench.master.chest_xy.back().x - expected.base().x) < 2e-3);
  RC_ASSERT(std::abs(bench.master.chest_xy.back().y - expected.base().y) < 2e-3);
  RC_ASSERT(std::abs(wrap_angle(bench.master.chest_zrot.back().yaw - expected.base().yaw)) < 1e-4);
  RC_ASSERT(bench.master.status.seq_executing == count - 1);
  RC_ASSERT(bench.control.counters().rejected == 0U);
}

TEST(ControlComputer, BeginsWithOneStepAndTakesTheNextWhileItShiftsItsWeight) {
  // The second has to be there 0.5 s before the first one's lift-off, the third 0.3 s after it.
  struct Walk {
    double second, third;  // [s] after the first
    std::uint32_t landed;
  };
  for (const auto& [second, third, landed] : {Walk{0.75, 1.5, 3}, {0.75, 1.7, 2}, {0.9, 0.95, 1}}) {
    WalkBench bench;
    bench.begin(1);
    bench.master.send_step(1, 0, forward_step(Foot::kLeft));
    bench.run(0.045);
    EXPECT_EQ(bench.master.status.state, State::kWalking);
    EXPECT_EQ(bench.master.status.seq_executing, 0);
    bench.run(second - 0.045);
    bench.master.send_step(1, 1, forward_step(Foot::kRight));
    bench.run(third - second);
    bench.master.send_step(1, 2, forward_step(Foot::kLeft));
    bench.run(5.0);
    EXPECT_EQ(bench.master.status.state, State::kStanding);
    EXPECT_EQ(bench.control.walking().landed, landed);
    EXPECT_EQ(bench.master.status.reject_reason, landed < 3 ? Reject::kLate : Reject::kNone);
  }
}

TEST(ControlComputer, EndsTheWalkWhenAStepComesAfterItsDeadline) {
  WalkBench bench;
  bench.begin(1);
  const auto steps = forward_steps(6);
  for (std::uint32_t i = 0; i < 3; ++i) bench.master.send_step(1, i, steps[i]);
  while (bench.control.status().executing != 1) bench.tick();
  bench.run(0.31);
  bench.master.send_step(1, 3, steps[3]);
  bench.run(0.03);
  EXPECT_EQ(bench.master.status.reject_reason, Reject::kLate);
  EXPECT_EQ(bench.master.status.seq_rejected, 3);
  EXPECT_EQ(bench.master.status.state, State::kStopping);
  bench.run(3);
  EXPECT_EQ(bench.master.status.state, State::kStanding);
  EXPECT_EQ(bench.control.walking().landed, 3U);
}

TEST(ControlComputer, AcknowledgesARepeatedStepOnce) {
  WalkBench bench;
  bench.begin(1);
  for (int i = 0; i < 3; ++i) bench.master.send_step(1, 0, forward_step(Foot::kLeft));
  bench.run(0.03);
  EXPECT_EQ(bench.master.status.seq_accepted, 0);
  EXPECT_EQ(bench.master.status.reject_reason, Reject::kNone);
  EXPECT_EQ(bench.control.counters().accepted, 1U);
}

TEST(ControlComputer, RejectsWithTheReason) {
  WalkBench bench;
  const auto reason = [&](std::uint8_t session, std::uint32_t index, const hal::Footstep& step) {
    bench.master.send_step(session, index, step);
    bench.run(0.025);
    return bench.master.status.reject_reason;
  };
  EXPECT_EQ(reason(1, 0, forward_step(Foot::kLeft)), Reject::kSession) << "no walk asked for yet";
  bench.begin(1);
  EXPECT_EQ(bench.master.status.reject_reason, Reject::kNone) << "a new walk starts clean";
  EXPECT_EQ(reason(2, 0, forward_step(Foot::kLeft)), Reject::kSession);
  EXPECT_EQ(reason(1, 1, forward_step(Foot::kLeft)), Reject::kSequence);
  EXPECT_EQ(reason(1, 0, forward_step(Foot::kLeft, 0.3)), Reject::kReach);
  EXPECT_EQ(reason(1, 0, {Foot::kLeft, {0, -0.19, 0}}), Reject::kReach) << "feet crossed";
  EXPECT_EQ(reason(1, 0, {Foot::kLeft, {0, 0.19, 0}, 0, seconds(0.5)}), Reject::kReach) << "too fast";
  EXPECT_EQ(reason(1, 0, {Foot::kLeft, {0, 0.19, 0}, 0.08}), Reject::kReach) << "a stair";
  EXPECT_EQ(reason(1, 0, forward_step(Foot::kLeft)), Reject::kNone);
  EXPECT_EQ(reason(1, 1, forward_step(Foot::kLeft)), Reject::kReach) << "the same foot again";
  bench.control.fail();
  EXPECT_EQ(reason(1, 1, forward_step(Foot::kRight)), Reject::kState);
  EXPECT_EQ(bench.master.status.state, State::kFault);
}

TEST(ControlComputer, HasRoomForEightSteps) {
  WalkBench bench;
  bench.begin(1);
  const auto steps = forward_steps(12);
  for (std::uint32_t i = 0; i < 9; ++i) bench.master.send_step(1, i, steps[i]);
  bench.run(0.025);
  EXPECT_EQ(bench.control.counters().accepted, 8U);
  EXPECT_EQ(bench.master.status.reject_reason, Reject::kFull);
  EXPECT_EQ(bench.master.status.seq_rejected, 8);
  EXPECT_EQ(bench.master.status.queue_free, 1) << "the first has started";
  bench.master.send_step(1, 8, steps[8]);
  bench.run(0.025);
  EXPECT_EQ(bench.master.status.seq_accepted, 8);
  EXPECT_EQ(bench.master.status.reject_reason, Reject::kNone);
  EXPECT_EQ(bench.master.status.queue_free, 0);
}

TEST(ControlComputer, BeginsNoWalkThatItHasForgotten) {
  WalkBench bench;
  bench.begin(1);
  bench.master.send_step(1, 0, forward_step(Foot::kLeft));
  bench.control.receive(bench.master.last_sent);
  ASSERT_EQ(bench.control.pattern().pushed(), 1U);
  bench.control.restart(seconds(1));
  bench.run(6);
  EXPECT_EQ(bench.control.walking().landed, 0U);
}

TEST(ControlComputer, FinishesAcceptedStepsOnASmoothStop) {
  WalkBench bench;
  bench.begin(1);
  const auto steps = forward_steps(9);
  for (std::uint32_t i = 0; i < 5; ++i) bench.master.send_step(1, i, steps[i]);
  while (bench.control.status().executing != 1) bench.tick();
  bench.request = Request::kSmoothStop;
  bench.run(0.1);
  EXPECT_EQ(bench.master.status.state, State::kStopping);
  bench.master.send_step(1, 5, steps[5]);
  bench.run(0.05);
  EXPECT_EQ(bench.master.status.reject_reason, Reject::kState);
  bench.run(5);
  EXPECT_EQ(bench.master.status.state, State::kStanding);
  EXPECT_EQ(bench.control.walking().landed, 5U);
}

TEST(ControlComputer, WalksOnlyTheTwoStepsItMustOnAnAbort) {
  WalkBench bench;
  bench.begin(1);
  const auto steps = forward_steps(9);
  for (std::uint32_t i = 0; i < 8; ++i) bench.master.send_step(1, i, steps[i]);
  while (bench.control.status().executing != 1) bench.tick();
  bench.request = Request::kAbort;
  const Time asked = bench.now;
  while (bench.control.status().state != hal::WalkState::kStanding) bench.tick();
  EXPECT_EQ(bench.control.walking().landed, 3U) << "the third is not needed yet";
  EXPECT_LE(to_seconds(bench.now - asked), 2.7);
}

TEST(ControlComputer, StopsWhenItsMasterFallsSilent) {
  WalkBench bench;
  bench.begin(1);
  const auto steps = forward_steps(6);
  for (std::uint32_t i = 0; i < 4; ++i) bench.master.send_step(1, i, steps[i]);
  bench.run(0.5);
  bench.session = 0;
  bench.run(0.11);
  EXPECT_EQ(bench.master.status.state, State::kWalking);
  bench.run(0.09);
  EXPECT_EQ(bench.master.status.state, State::kStopping);
  bench.run(7);
  EXPECT_EQ(bench.control.walking().landed, 4U);
}

TEST(ControlComputer, StartsANewWalkOnlyAfterTheLastHasEnded) {
  WalkBench bench;
  bench.begin(1);
  for (std::uint32_t i = 0; i < 3; ++i) bench.master.send_step(1, i, forward_steps(3)[i]);
  bench.run(1);
  bench.begin(2);
  EXPECT_EQ(bench.master.status.session, 1);
  bench.request = Request::kWalk;
  bench.run(6);
  EXPECT_EQ(bench.master.status.session, 2);
  EXPECT_EQ(bench.master.status.seq_accepted, 255);
  EXPECT_TRUE(bench.walk(forward_steps(4)));
  EXPECT_EQ(bench.control.walking().landed, 7U);
}

using OrderKind = hal::WalkOrder::Kind;

/// The stance after the first `count` steps of an order.
hal::Stance after(const hal::WalkOrder& order, std::size_t count, hal::Stance stance,
                  std::optional<hal::Foot> last = {}) {
  const auto steps = nav::steps_of(order, stance, last, nav::GaitLimits{});
  for (std::size_t i = 0; i < count; ++i) stance = stance.after(steps.value().steps[i]);
  return stance;
}

void expect_same(const hal::Stance& a, const hal::Stance& b) {
  for (const hal::Foot foot : {hal::Foot::kLeft, hal::Foot::kRight}) {
    EXPECT_EQ(a.at(foot).x, b.at(foot).x);
    EXPECT_EQ(a.at(foot).y, b.at(foot).y);
    EXPECT_EQ(a.at(foot).yaw, b.at(foot).yaw);
  }
}

TEST(ControlComputer, WalksAnOrderAsFarAsItIsReleased) {
  for (const std::uint8_t last_seq : {std::uint8_t{2}, std::uint8_t{5}}) {
    WalkBench bench;
    bench.begin(1);
    const hal::WalkOrder order{OrderKind::kStraightWithTurn, 1.6, 0, 0.1};
    bench.master.send_order(1, 0, order);
    bench.run(0.1);
    EXPECT_EQ(bench.control.status().accepted, 0) << "with its first step";
    bench.master.last_seq = last_seq;
    bench.run(20);
    EXPECT_EQ(bench.control.status().state, hal::WalkState::kStanding);
    EXPECT_EQ(bench.control.status().executing, last_seq);
    expect_same(bench.control.pattern().planned_stance(), after(order, last_seq + 1U, bench.start_stance));
    EXPECT_EQ(bench.control.counters().orders, 1U);
  }
}

TEST(ControlComputer, GoesOverToANewerOrderInPlaceOfWhatWasNotReleased) {
  WalkBench bench;
  bench.begin(1);
  const hal::WalkOrder straight{OrderKind::kStraightWithTurn, 1.6, 0, 0}, arc{OrderKind::kArc, 0, 1, 0.3};
  bench.master.send_order(1, 0, straight);
  bench.master.last_seq = 2;
  bench.run(0.2);
  EXPECT_EQ(bench.control.status().accepted, 2);
  bench.master.send_order(1, 3, arc);
  bench.run(0.1);
  EXPECT_EQ(bench.control.status().accepted, 3);
  bench.master.last_seq = 5;
  bench.run(20);
  EXPECT_EQ(bench.control.status().executing, 5);
  const hal::Stance turning = after(straight, 3, bench.start_stance);
  expect_same(bench.control.pattern().planned_stance(), after(arc, 3, turning, hal::Foot::kLeft));
}

TEST(ControlComputer, RejectsOrdersThatItCannotWalk) {
  WalkBench bench;
  bench.begin(1);
  const auto reason = [&](std::uint32_t index, const hal::WalkOrder& order) {
    bench.master.send_order(1, index, order);
    bench.run(0.05);
    return bench.control.status().reject_reason;
  };
  EXPECT_EQ(reason(0, {OrderKind::kNextStep, 0.5, 0, 0}), hal::StepReject::kReach);
  EXPECT_EQ(reason(0, {OrderKind::kStraightWithTurn, 8, 0, 0}), hal::StepReject::kReach);
  EXPECT_EQ(reason(4, {OrderKind::kArc, 0, 0, 0.3}), hal::StepReject::kSequence);
  EXPECT_EQ(reason(0, {OrderKind::kArc, 0, 0, 0.3}), hal::StepReject::kNone);
}

TEST(ControlComputer, NeverUsesADamagedOrRepeatedFrame) {
  WalkBench bench;
  bench.begin(1);
  bench.can.corrupt_by(
      [](const hal::CanFrame& f) { return f.id == 0x120 ? std::optional(56U) : std::nullopt; });
  bench.master.send_step(1, 0, forward_step(Foot::kLeft));
  bench.run(0.02);
  EXPECT_EQ(bench.control.counters().accepted, 0U);
  EXPECT_EQ(bench.control.counters().unusable, 1U);
  bench.can.corrupt_by({});
  bench.master.send_step(1, 0, forward_step(Foot::kLeft));
  bench.master.send_step(1, 1, forward_step(Foot::kRight));
  bench.run(0.02);
  EXPECT_EQ(bench.control.counters().accepted, 2U);
}

TEST(ControlComputer, UsesNoFrameAfterMoreThanFourLost) {
  WalkBench bench;
  bench.begin(1);
  const auto lose = [&](int frames) {
    hal::CanFrame lost = bench.master.last_sent;
    for (int i = 0; i < frames; ++i) bench.master.step_out_.protect(lost);
  };
  bench.master.send_step(1, 0, forward_step(Foot::kLeft));
  lose(4);
  bench.master.send_step(1, 1, forward_step(Foot::kRight));
  bench.run(0.02);
  EXPECT_EQ(bench.control.counters().accepted, 2U) << "the counter is five ahead";
  lose(5);
  bench.master.send_step(1, 2, forward_step(Foot::kLeft));
  bench.run(0.02);
  EXPECT_EQ(bench.control.counters().accepted, 2U);
  EXPECT_EQ(bench.control.counters().unusable, 1U);
  bench.master.send_step(1, 2, forward_step(Foot::kLeft));
  bench.run(0.02);
  EXPECT_EQ(bench.control.counters().accepted, 3U) << "the next is measured from it";
}

TEST(ControlComputer, CountsMoreThan64StepsWithoutLosingItsPlace) {
  WalkBench bench;
  bench.begin(5);
  EXPECT_TRUE(bench.walk(forward_steps(70)));
  EXPECT_EQ(bench.control.walking().landed, 70U);
  EXPECT_EQ(bench.control.counters().rejected, 0U);
  bench.run(0.03);
  EXPECT_EQ(bench.master.status.seq_executing, 69 % 64);
}

TEST(ControlComputer, RefusesAConfigurationThatCannotBe) {
  ControlComputerConfig config;
  config.limits.farthest_side = 0.1;
  EXPECT_THROW(config.validate(), InputError);
  config = {};
  config.chest.height = -1;
  EXPECT_THROW(config.validate(), InputError);
}

}  // namespace
}  // namespace headway::sim
