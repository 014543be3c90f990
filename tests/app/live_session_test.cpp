// The program on threads and a real clock (a fast one), and the simulated robot moving by the same clock.
#include "app/live_session.h"

#include <array>
#include <atomic>
#include <functional>
#include <span>
#include <thread>

#include <gtest/gtest.h>

#include "app/commands.h"
#include "app/end_at_once.h"
#include "app/live_control.h"
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
      for (runtime::SafetyChange change; session.look(change);) continue;
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
  // Nor do the head's drives miss it: a second later none has sent an emergency.
  std::array<hal::CanFrame, 32> frames;
  for (const Time end = bench.clock.now() + seconds(1); bench.clock.now() < end;) {
    const std::size_t count = bench.wires.receive(frames);
    for (const hal::CanFrame& frame : std::span(frames).first(count))
      EXPECT_TRUE(frame.id != 0x091 && frame.id != 0x092);
    bench.clock.sleep_until(bench.clock.now() + seconds(0.005));
  }
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

TEST(LiveSessionSlow, ComesToRestAndIsNotWaitedForWhenTheFrameLoopHangs) {
  Bench bench;
  bench.session.start();
  ASSERT_TRUE(bench.until_under_way());
  bench.pictures.hang = true;
  while (!bench.pictures.hung) std::this_thread::yield();
  const Time asked = bench.clock.now();
  EXPECT_TRUE(bench.session.stop());
  EXPECT_LT(bench.clock.now() - asked, seconds(15));
  EXPECT_STREQ(bench.session.left_hanging(), "frame");
  bench.expect_rest_on_the_way();
  bench.pictures.hang = false;
  bench.session.stop();
  EXPECT_STREQ(bench.session.left_hanging(), "");
}

TEST(EndAtOnceDeathTest, NamesTheFaultInOneLineAndEndsWithTheExitCodeForIt) {
  EXPECT_EXIT(end_at_once("the frame loop hangs"), testing::ExitedWithCode(kInternal),
              "^headway: the frame loop hangs\n$");
}

TEST(LiveSessionSlow, SaysThatItHasGivenUpWhenItHasBeenBlindForLong) {
  Bench bench;
  bench.session.start();
  ASSERT_TRUE(bench.until_under_way());
  bench.wires.blind = true;
  EXPECT_TRUE(bench.until(runtime::MissionState::kStopped, 20));
  EXPECT_NE(std::string(bench.status.reason.data()).find("stopped for safety: pictures too old"),
            std::string::npos)
      << bench.status.reason.data();
  EXPECT_EQ(bench.session.bus_loop().safety().state, runtime::SafetyState::kSafeStop);
  EXPECT_TRUE(bench.session.stop());
  bench.expect_rest_on_the_way();
}

/// What the program says to a line from the operator.
Json asked(Bench& bench, const std::string& line) {
  return Json::parse(answer(line, bench.session, bench.status, bench.clock.now()));
}

TEST(LiveSessionSlow, IsSentElsewhereWhileItRunsAndComesToRestWhenToldTo) {
  Bench bench;
  bench.session.start();
  ASSERT_TRUE(bench.until_under_way());
  EXPECT_EQ(asked(bench, R"({"do": "stay"})").at("ok"), true);
  EXPECT_TRUE(bench.until(runtime::MissionState::kStopped, 5));
  EXPECT_TRUE(bench.until([](const LiveStatus& s) { return s.at_rest; }, 5));
  const Json resting = asked(bench, R"({"do": "status"})");
  EXPECT_EQ(resting.at("state"), "stopped");
  EXPECT_EQ(resting.at("safety").at("state"), "safe stop");
  EXPECT_EQ(resting.at("at_rest"), true);
  const Json sent = asked(bench, R"({"do": "go", "to": [0.1, 0.5], "from": "map"})");
  EXPECT_EQ(sent.at("ok"), true) << sent;
  EXPECT_TRUE(bench.until(runtime::MissionState::kArrived, 120)) << bench.status.reason.data();
  EXPECT_TRUE(bench.session.stop());
  const Eigen::Vector2d end = bench.node.body().stance().base().position();
  EXPECT_LT((end - Eigen::Vector2d(0.1, 0.5)).norm(), kArrivedWithin);
}

TEST(LiveSession, RefusesOrdersThatMakeNoSenseAndSaysWhy) {
  Bench bench;
  bench.status.stamp = bench.clock.now();
  for (const auto& [line, why] : std::vector<std::pair<std::string, std::string>>{
           {"go on", "not JSON"},
           {"[]", "expected an object"},
           {"{}", "do: expected"},
           {R"({"do": "dance"})", "do: expected"},
           {R"({"do": "go"})", "to: expected two numbers"},
           {R"({"do": "go", "to": [1]})", "to: expected two numbers"},
           {R"({"do": "go", "to": [1, "2"]})", "to[1]: expected a number"},
           {R"({"do": "go", "to": [1, 1e99]})", "to[1]: expected a number"},
           {R"({"do": "go", "to": [1, 0], "yaw_deg": 900})", "yaw_deg: expected a number from -360"},
           {R"({"do": "go", "to": [1, 0], "near": 1})", "near: expected true or false"},
           {R"({"do": "go", "to": [1, 0], "from": "moon"})", "from: expected"},
           {R"({"do": "go", "to": [40, 0]})", "outside the floor in use"}}) {
    const Json said = asked(bench, line);
    EXPECT_EQ(said.at("ok"), false) << line;
    EXPECT_NE(said.at("error").get<std::string>().find(why), std::string::npos) << line << ": " << said;
  }
  bench.status.stamp = {};
  EXPECT_EQ(asked(bench, R"({"do": "go", "to": [1, 0]})").at("ok"), false) << "nobody knows from where";
}

TEST(LiveSession, SaysWhenNobodyTakesGoals) {
  Bench bench;
  bench.status.stamp = bench.clock.now();
  bool full = false;
  for (int i = 0; i < 40 && !full; ++i)
    full = asked(bench, R"({"do": "go", "to": [0.1, 0]})").at("ok") == false;
  EXPECT_TRUE(full);
}

TEST(LiveSession, TellsHowItIsAsTextAndAsMetrics) {
  Bench bench;
  const Json before = asked(bench, R"({"do": "status"})");
  EXPECT_TRUE(before.at("age_s").is_null());
  EXPECT_NE(status_text(before).find("no frame has been worked on yet"), std::string::npos);
  bench.session.start();
  ASSERT_TRUE(bench.until(runtime::MissionState::kLookAround, 30));
  const Json status = asked(bench, R"({"do": "status"})");
  EXPECT_TRUE(bench.session.stop());
  EXPECT_NE(status_text(status).find("look around"), std::string::npos) << status_text(status);
  const std::string metrics = status_metrics(status);
  EXPECT_NE(metrics.find("\nheadway_frames_used_total "), std::string::npos) << metrics;
  EXPECT_NE(metrics.find("headway_state{state=\"look around\"} 1\n"), std::string::npos) << metrics;
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
