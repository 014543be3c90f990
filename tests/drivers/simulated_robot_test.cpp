// Both masters against the simulated robot, whose drives and control computer were written from the standards
// and docs/bus.md without looking at them.
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/can_walker.h"
#include "drivers/cia402_head.h"
#include "sim_hal/robot.h"
#include "tests/drivers/noise.h"

namespace headway::drivers {
namespace {

using hal::HeadHealth;
using hal::WalkerHealth;
using hal::WalkRequest;
using hal::WalkState;

class SimulatedRobot : public ::testing::Test {
 protected:
  explicit SimulatedRobot(const HeadConfig& config = {}, const sim::RobotConfig& body = {})
      : robot(body, Pose2{}), head(robot.bus(), config) {}

  void cycle() {
    now += sim::SimRobot::kPeriod;
    robot.step(now);
    std::array<hal::CanFrame, 32> frames;
    for (std::size_t n; (n = robot.bus().receive(frames)) > 0;) {
      for (std::size_t i = 0; i < n; ++i) {
        head.receive(frames[i]);
        walker.receive(frames[i]);
      }
    }
    head.tick(now);
    walker.tick(now);
  }
  bool until(const std::function<bool()>& done, double limit) {
    for (const Time end = now + seconds(limit); now < end && !done();) cycle();
    return done();
  }
  bool ready(double limit = 3) {
    return until([&] { return head.state().health == HeadHealth::kReady; }, limit);
  }
  /// Steps on the spot, then smoothly to rest; whether all were accepted and the robot stands again.
  bool walk(std::uint8_t session, std::uint32_t steps) {
    std::uint32_t next = 0;
    walker.control(WalkRequest::kWalk, session, {});
    const auto all_taken = [&] {
      const bool left = next % 2 == 0;
      const hal::Footstep step{
          left ? hal::Foot::kLeft : hal::Foot::kRight, {0, left ? 0.19 : -0.19, 0}, 0, seconds(0.8)};
      if (next < steps && walker.send(session, {next, step})) ++next;
      return next == steps && walker.unanswered() == 0;
    };
    if (!until(all_taken, 2.0 + 2.0 * steps)) return false;
    walker.control(WalkRequest::kSmoothStop, session, {});
    return until(
        [&] {
          return walker.status().session == session && walker.status().state == WalkState::kStanding &&
                 walker.status().executing == (steps - 1) % 64;
        },
        5.0 + steps);
  }

  /// Walks an arc, a straight, another arc and a step, and sees whether the feet stand where those orders
  /// mean.
  void walk_four_orders() {
    using Kind = hal::WalkOrder::Kind;
    hal::Stance stance = hal::Stance::parallel({}, 0.19);
    std::optional<hal::Foot> last;
    std::vector<hal::NumberedStep> steps;
    for (const hal::WalkOrder& order :
         {hal::WalkOrder{Kind::kArc, 0, 0, 0.3}, hal::WalkOrder{Kind::kStraightWithTurn, 0.9, 0.04, -0.06},
          hal::WalkOrder{Kind::kArc, 0, -1.2, -0.4}, hal::WalkOrder{Kind::kNextStep, 0, 0, 0}}) {
      const auto meant = nav::steps_of(order, stance, last, nav::GaitLimits{});
      ASSERT_TRUE(meant);
      for (std::size_t i = 0; i < meant->count; ++i) {
        const auto index = static_cast<std::uint32_t>(steps.size());
        steps.push_back({index, meant->steps[i], hal::PartOfOrder{order, static_cast<std::uint8_t>(i)}});
        stance = stance.after(meant->steps[i]);
        last = meant->steps[i].foot;
      }
    }
    std::size_t next = 0;
    walker.control(WalkRequest::kWalk, 1, {});
    ASSERT_TRUE(until(
        [&] {
          if (next < steps.size() && walker.status().session == 1 && walker.status().queue_free > 4 &&
              walker.unanswered() < 2 && walker.send(1, steps[next]))
            ++next;
          return next == steps.size() && walker.status().state == WalkState::kStanding &&
                 walker.status().executing == (steps.size() - 1) % 64;
        },
        60));
    const hal::Stance& walked = robot.control().pattern().planned_stance();
    EXPECT_EQ(walked.left.x, stance.left.x);
    EXPECT_EQ(walked.left.y, stance.left.y);
    EXPECT_EQ(walked.right.x, stance.right.x);
    EXPECT_EQ(walked.right.yaw, stance.right.yaw);
    EXPECT_EQ(robot.control().counters().orders, 4U);
  }
  /// How far the head turns while a drive reboots and is set up again [rad].
  double turned_by_a_reboot() {
    EXPECT_TRUE(ready());
    head.command({0.4, 0.3});
    EXPECT_TRUE(until([&] { return !head.state().moving; }, 3));
    until([] { return false; }, 0.1);
    robot.pan_drive().reboot();
    const double before = robot.head().pan;
    EXPECT_TRUE(until([&] { return head.state().health != HeadHealth::kReady; }, 1));
    double worst = 0;
    const auto is_back = [&] {
      worst = std::max(worst, std::abs(robot.head().pan - before));
      return head.state().health == HeadHealth::kReady;
    };
    EXPECT_TRUE(until(is_back, 5));
    return worst;
  }

  /// From now on one frame in ten of those between the two computers is lost, and one in twenty damaged.
  void disturb() {
    const auto one_in = [this](std::uint32_t n) { return noise.below(n) == 0; };
    robot.can().drop_if([=](const hal::CanFrame& f) { return f.id >= 0x120 && f.id <= 0x140 && one_in(10); });
    robot.can().corrupt_by([=](const hal::CanFrame& f) {
      const bool hit = f.id >= 0x120 && f.id <= 0x140 && one_in(20);
      return hit ? std::optional(8U * f.dlc - 8U) : std::nullopt;
    });
  }

  sim::SimRobot robot;
  Cia402Head head;
  CanWalker walker{robot.bus()};
  Time now{};
  testing::Noise noise{7};
};

TEST_F(SimulatedRobot, HasItsHeadReadyWithinTwoSeconds) {
  EXPECT_TRUE(ready(2));
  EXPECT_EQ(walker.health(), WalkerHealth::kReady);
  EXPECT_NEAR(robot.head().pan, 0, 1e-4);
}

TEST_F(SimulatedRobot, LooksWhereItIsToldAndReportsWhereItLooks) {
  ASSERT_TRUE(ready());
  head.command({0.4, 0.3});
  double worst = 0;
  ASSERT_TRUE(until(
      [&] {
        // A report is at most a SYNC old: 20 ms and a few of transport at 1 rad/s.
        worst = std::max(worst, std::abs(head.state().position.pan - robot.head().pan));
        return !head.state().moving;
      },
      3));
  EXPECT_LT(worst, 0.04);
  EXPECT_NEAR(robot.head().pan, 0.4, 2e-3);
  EXPECT_NEAR(robot.head().tilt, 0.3, 2e-3);
}

TEST_F(SimulatedRobot, HasItsHeadBackThatHasMissedOurHeartbeatOnceItIsRecovered) {
  ASSERT_TRUE(ready());
  for (const Time end = now + seconds(1); now < end;) {
    now += sim::SimRobot::kPeriod;
    robot.step(now);  // and nobody looks at the bus
  }
  ASSERT_TRUE(until([&] { return head.state().health != HeadHealth::kReady; }, 0.1));
  EXPECT_EQ(head.pan().emergency_code, 0x8130);
  EXPECT_FALSE(until([&] { return head.state().health == HeadHealth::kReady; }, 3)) << "unasked";
  head.recover();
  EXPECT_TRUE(ready());
}

TEST_F(SimulatedRobot, NeverTurnsBeyondItsLimits) {
  ASSERT_TRUE(ready());
  for (const hal::HeadAngles far : {hal::HeadAngles{3, 3}, hal::HeadAngles{-3, -3}}) {
    head.command(far);
    until(
        [&] {
          EXPECT_LT(std::abs(robot.head().pan), 0.787);
          EXPECT_GT(robot.head().tilt, -0.525);
          return !head.state().moving;
        },
        5);
  }
  EXPECT_NEAR(robot.head().pan, -0.7854, 2e-3);
}

TEST_F(SimulatedRobot, ComesBackWithoutAJumpWhenADriveReboots) {
  EXPECT_LT(turned_by_a_reboot(), 5e-3);
  EXPECT_EQ(head.pan().boot_ups, 2u);
}

TEST_F(SimulatedRobot, FaultsWhileADriveIsSilentAndComesBackWithIt) {
  ASSERT_TRUE(ready());
  robot.tilt_drive().set_silent(true);
  ASSERT_TRUE(until([&] { return head.state().health == HeadHealth::kFault; }, 1));
  EXPECT_EQ(head.tilt().failure, DriveFailure::kGone);
  robot.tilt_drive().set_silent(false);
  EXPECT_TRUE(ready(5));
}

/// The same robot, its head led cyclically.
class CyclicSimulatedRobot : public SimulatedRobot {
 protected:
  static HeadConfig cyclic() {
    HeadConfig config;
    config.set_points = SetPointMode::kCyclic;
    return config;
  }
  CyclicSimulatedRobot() : SimulatedRobot(cyclic()) {}
};

TEST_F(CyclicSimulatedRobot, LooksWhereItIsToldSmoothlyAndNoFurtherThanItMay) {
  ASSERT_TRUE(ready());
  double before = robot.head().pan, fastest = 0;
  for (const hal::HeadAngles target : {hal::HeadAngles{0.4, 0.3}, hal::HeadAngles{-3, -3}}) {
    head.command(target);
    ASSERT_TRUE(until(
        [&] {
          fastest = std::max(fastest, std::abs(robot.head().pan - before) / 0.005);
          before = robot.head().pan;
          EXPECT_LT(std::abs(robot.head().pan), 0.787);
          EXPECT_GT(robot.head().tilt, -0.525);
          return !head.state().moving;
        },
        5));
    until([] { return false; }, 0.1);
    EXPECT_NEAR(robot.head().pan, std::max(target.pan, -0.7854), 2e-3);
    EXPECT_NEAR(robot.head().tilt, std::max(target.tilt, -0.5236), 2e-3);
  }
  EXPECT_GT(fastest, 0.95);
  EXPECT_LT(fastest, 1.05);
}

TEST_F(CyclicSimulatedRobot, ComesBackWithoutAJumpWhenADriveReboots) {
  EXPECT_LT(turned_by_a_reboot(), 1e-4);
}

/// The same robot, whose pan drive takes for zero where it was switched on.
class UnhomedSimulatedRobot : public SimulatedRobot {
 protected:
  static HeadConfig config(HomingConfig::Policy policy) {
    HeadConfig config;
    config.homing.policy = policy;
    config.homing.method = 17;
    return config;
  }
  static sim::RobotConfig unhomed() {
    sim::RobotConfig config;
    config.pan.homed = false;
    config.pan.start_angle = 0.2;
    return config;
  }
  explicit UnhomedSimulatedRobot(HomingConfig::Policy policy = HomingConfig::Policy::kMove)
      : SimulatedRobot(config(policy), unhomed()) {}
};
class UnhomedSimulatedRobotThatMayNotMove : public UnhomedSimulatedRobot {
 protected:
  UnhomedSimulatedRobotThatMayNotMove() : UnhomedSimulatedRobot(HomingConfig::Policy::kRequired) {}
};

TEST_F(UnhomedSimulatedRobot, IsHomedAndThenLooksWhereItIsTold) {
  ASSERT_TRUE(ready(10));
  EXPECT_NEAR(robot.head().pan, 0, 1e-3);
  head.command({0.4, 0.3});
  ASSERT_TRUE(until([&] { return !head.state().moving; }, 3));
  EXPECT_NEAR(robot.head().pan, 0.4, 2e-3);
}

TEST_F(UnhomedSimulatedRobotThatMayNotMove, StandsStillInItsNamedState) {
  ASSERT_TRUE(until([&] { return head.state().health == HeadHealth::kNotHomed; }, 3));
  head.command({0.4, 0.3});
  until([] { return false; }, 3);
  EXPECT_EQ(head.state().health, HeadHealth::kNotHomed);
  EXPECT_NEAR(robot.head().pan, 0.2, 1e-6);
}

TEST_F(SimulatedRobot, WalksTheStepsThatItsOrdersMean) {
  ASSERT_TRUE(ready());
  walk_four_orders();
  EXPECT_FALSE(robot.fallen());
}

TEST_F(SimulatedRobot, WalksTheStepsThatItsOrdersMeanThoughFramesAreLostAndDamaged) {
  ASSERT_TRUE(ready());
  disturb();
  walk_four_orders();
  EXPECT_GT(robot.control().counters().unusable, 0u);
  EXPECT_GT(walker.counts().wrong_crc, 0u);
  EXPECT_FALSE(robot.fallen());
}

TEST_F(SimulatedRobot, WalksEveryStepOfTwoSessions) {
  ASSERT_TRUE(ready());
  EXPECT_TRUE(walk(1, 6));
  EXPECT_TRUE(walk(2, 70));  // past the turn of the numbers
  EXPECT_EQ(robot.control().counters().accepted, 76u);
  EXPECT_EQ(robot.control().counters().rejected, 0u);
  EXPECT_EQ(robot.control().counters().unusable, 0u);
  EXPECT_FALSE(robot.fallen());
}

TEST_F(SimulatedRobot, WalksEveryStepThoughFramesAreLostAndDamaged) {
  ASSERT_TRUE(ready());
  disturb();
  EXPECT_TRUE(walk(1, 20));
  EXPECT_EQ(robot.control().counters().accepted, 20u);
  EXPECT_GT(robot.control().counters().unusable, 0u);
  EXPECT_GT(walker.counts().wrong_crc, 0u);
  EXPECT_FALSE(robot.fallen());
}

TEST_F(SimulatedRobot, KnowsItsChestAtItsTime) {
  ASSERT_TRUE(ready());
  const auto chest = walker.chest();
  EXPECT_LT(now - chest.stamp, std::chrono::milliseconds(60));
  EXPECT_TRUE(chest.odom_from_chest.isApprox(robot.control().odom_from_chest(), 1e-2));
}

}  // namespace
}  // namespace headway::drivers
