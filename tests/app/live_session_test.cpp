// The program on threads and a real clock (a fast one), and the simulated robot moving by the same clock.
#include "app/live_session.h"

#include <atomic>
#include <functional>

#include <gtest/gtest.h>

#include "app/node_session.h"
#include "app/sim_session.h"
#include "hal/error.h"
#include "tests/app/robot_on_bus.h"

namespace headway::app {
namespace {

struct Bench {
  explicit Bench(double slower = 0.25) : clock(slower) {}
  /// Looks at the status until it is so, or that much time has passed.
  bool until(const std::function<bool(const LiveStatus&)>& so, double longest) {
    const Time end = clock.now() + seconds(longest);
    while (clock.now() < end && !so(status)) {
      session.look(status);
      clock.sleep_until(clock.now() + seconds(0.05));
    }
    return so(status);
  }
  bool until(runtime::MissionState state, double longest) {
    return until([state](const LiveStatus& s) { return s.state == state; }, longest);
  }
  bool until_under_way() {
    return until(
        [](const LiveStatus& s) { return s.state == runtime::MissionState::kWalk && s.base.x > -0.5; }, 90);
  }
  void expect_rest_on_the_way() const {
    EXPECT_FALSE(node.body().fallen());
    EXPECT_TRUE(session.bus_loop().committed().at_rest);
    EXPECT_LT(node.body().stance().base().x, 0.5);
    EXPECT_GT(node.body().stance().base().x, -0.8);
  }

  hal::ScaledClock clock;
  Robot robot = hrp2();
  NodeSession node{robot, empty_room(), {}, true, clock.now()};
  RobotOnBus wires{node, clock};
  Pictures pictures{wires};
  runtime::DepthEyes eyes{pictures, node.depth_eyes()};
  LiveSession session{
      robot,
      {.start = {-0.8, 0, 0}, .floor = {8, 8}, .goal = nav::Goal{{0.7, 0.1}, {}}, .frame_rate = 10},
      wires,
      eyes,
      clock};
  LiveStatus status;
};

TEST(LiveSessionSlow, WalksTheSimulatedRobotToItsGoalOnTwoThreads) {
  Bench bench;
  bench.session.start();
  EXPECT_TRUE(bench.until(runtime::MissionState::kArrived, 120)) << bench.status.reason.data();
  EXPECT_TRUE(bench.session.stop());
  EXPECT_FALSE(bench.session.failure());
  EXPECT_FALSE(bench.node.body().collision());
  const Eigen::Vector2d end = bench.node.body().stance().base().position();
  EXPECT_LT((end - Eigen::Vector2d(0.7, 0.1)).norm(), kArrivedWithin);
}

TEST(LiveSessionSlow, ComesToRestBeforeItEnds) {
  Bench bench;
  bench.session.start();
  ASSERT_TRUE(bench.until_under_way());
  EXPECT_TRUE(bench.session.stop());
  bench.expect_rest_on_the_way();
}

TEST(LiveSessionSlow, ComesToRestWhenTheFrameLoopBreaks) {
  Bench bench;
  bench.session.start();
  ASSERT_TRUE(bench.until_under_way());
  bench.pictures.explode = true;
  for (int i = 0; i < 200 && !bench.session.failure(); ++i)
    bench.clock.sleep_until(bench.clock.now() + seconds(0.05));
  ASSERT_TRUE(bench.session.failure());
  EXPECT_EQ(*bench.session.failure(), "the cameras have melted");
  EXPECT_TRUE(bench.session.stop());
  bench.expect_rest_on_the_way();
}

TEST(LiveSessionSlow, SaysThatItHasGivenUpWhenItHasBeenBlindForLong) {
  Bench bench;
  bench.session.start();
  ASSERT_TRUE(bench.until_under_way());
  bench.wires.blind = true;
  EXPECT_TRUE(bench.until(runtime::MissionState::kStopped, 20));
  EXPECT_NE(std::string(bench.status.reason.data()).find("nothing has been seen for 10 s"), std::string::npos)
      << bench.status.reason.data();
  EXPECT_TRUE(bench.session.stop());
  bench.expect_rest_on_the_way();
}

TEST(LiveSession, HearsWhereTheRobotStands) {
  Bench bench;
  const auto stands = hear_where_it_stands(bench.wires, bench.clock, seconds(5));
  ASSERT_TRUE(stands);
  EXPECT_NEAR(stands->x, -0.8, 0.01);
  EXPECT_NEAR(stands->y, 0, 0.01);
  hal::ManualClock clock;
  hal::Clock& stepped = clock;
  struct Silence final : hal::CanBus {
    bool send(const hal::CanFrame&) noexcept override { return true; }
    std::size_t receive(std::span<hal::CanFrame>) noexcept override { return 0; }
    hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }
  } silence;
  EXPECT_FALSE(hear_where_it_stands(silence, stepped, seconds(5)));
}

TEST(LiveSession, RefusesAGoalBeyondTheFloorInUse) {
  Bench bench;
  const LiveOptions far{.start = {}, .floor = {8, 8}, .goal = nav::Goal{{4.5, 0}, {}}, .frame_rate = 10};
  EXPECT_THROW(LiveSession(bench.robot, far, bench.wires, bench.eyes, bench.clock), InputError);
}

}  // namespace
}  // namespace headway::app
