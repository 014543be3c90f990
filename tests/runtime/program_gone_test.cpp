// The program dies, at any moment of a walk: crashed, killed, or gone with its computer. What is left says
// nothing any more; head drives and control computer notice that by themselves, as docs/bus.md asks of them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include <gtest/gtest.h>

#include "drivers/can_walker.h"
#include "drivers/cia402_head.h"
#include "runtime/bus_loop.h"
#include "sim_hal/robot.h"

namespace headway::runtime {
namespace {

/// The real masters and bus loop, led by a frame loop that sees nothing but free floor, on the simulated
/// robot.
struct Program {
  explicit Program(sim::SimRobot& simulated)
      : robot(simulated),
        head(simulated.bus(), {}),
        walker(simulated.bus()),
        loop({.stance = hal::Stance::parallel({}, 0.19), .steps = {}}, simulated.bus(), head, walker,
             *links) {}

  void cycle(Time now) {
    loop.cycle(now);
    links->report.update();
    if (now < next_order) return;
    next_order = now + seconds(0.1);
    const nav::Committed& c = links->report.value().committed;
    MotionOrder order;
    order.look = {0.5 * std::sin(to_seconds(now)), 0.3};
    order.goal = true;
    order.walk = MotionOrder::Walk::kPlan;
    order.plan.session = c.session;
    order.plan.first_index = c.next_index;
    order.plan.count = 10;
    order.plan.newest_frame = order.seen = now;
    for (std::uint32_t i = 0; i < 10; ++i) {
      const bool left = (c.next_index + i) % 2 == 0;
      order.plan.steps[i] = hal::quantised(
          {left ? hal::Foot::kLeft : hal::Foot::kRight, {0.15, left ? 0.19 : -0.19, 0}, 0, seconds(0.8)});
    }
    links->order.publish(order);
  }

  sim::SimRobot& robot;
  drivers::Cia402Head head;
  drivers::CanWalker walker;
  std::unique_ptr<Links> links = std::make_unique<Links>();
  BusLoop loop;
  Time next_order{};
};

struct End {
  Duration rest{};  ///< from when the program was gone until the robot stood
  Duration head{};  ///< until the head stood
  std::uint32_t steps = 0;
};

/// The program runs for so long, and is gone.
End gone_after(Duration alive) {
  sim::SimRobot robot(sim::RobotConfig{.frame_rate = 0}, Pose2{});
  Time now{};
  End end;
  const auto step = [&] { robot.step(now += sim::SimRobot::kPeriod); };
  {
    Program program(robot);
    while (now.time_since_epoch() < alive) {
      step();
      program.cycle(now);
    }
  }
  const Time gone = now;
  for (int i = 0; i < 1600; ++i) {
    step();
    if (robot.control().status().state != hal::WalkState::kStanding) end.rest = now - gone;
    if (std::max(std::abs(robot.pan_drive().velocity()), std::abs(robot.tilt_drive().velocity())) > 1e-6)
      end.head = now - gone;
  }
  end.steps = robot.control().walking().landed;
  EXPECT_FALSE(robot.fallen());
  EXPECT_EQ(robot.control().status().state, hal::WalkState::kStanding);
  const auto stance = robot.stance();
  for (int i = 0; i < 1000; ++i) step();
  EXPECT_EQ(robot.stance().left.x, stance.left.x) << "and it stays there";
  return end;
}

TEST(ProgramGone, LeavesARobotThatComesToRestByItselfFromAnyMomentOfAWalk) {
  // The peers notice by themselves: 150 ms without WalkControl, 300 ms without our heartbeat.
  const Duration walker_notices = seconds(0.15), head_notices = seconds(0.3), rest = seconds(2.7);
  Duration longest{}, head{};
  std::uint32_t most = 0;
  for (Duration alive = seconds(0.3); alive < seconds(7); alive += seconds(0.035)) {
    SCOPED_TRACE(to_seconds(alive));
    const End end = gone_after(alive);
    EXPECT_LE(to_seconds(end.rest), to_seconds(walker_notices + rest));
    EXPECT_LE(to_seconds(end.head), to_seconds(head_notices) + 0.5) << "a quick stop";
    longest = std::max(longest, end.rest);
    head = std::max(head, end.head);
    most = std::max(most, end.steps);
  }
  EXPECT_GT(most, 5U) << "it did walk";
  std::printf("the program gone, at worst: at rest after %.3f s, head still after %.3f s\n",
              to_seconds(longest), to_seconds(head));
}

}  // namespace
}  // namespace headway::runtime
