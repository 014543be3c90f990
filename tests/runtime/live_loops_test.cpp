// Both loops on their threads, with a robot as simple as can be and eyes that show nothing.
#include "runtime/live_loops.h"

#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/runtime/fake_robot.h"
#include "tests/runtime/flat_room.h"
#include "tests/runtime/scripted_real_time.h"

namespace headway::runtime {
namespace {

class ShutEyes final : public Eyes {
 public:
  std::optional<FrameStamp> take() override {
    for (; hang; std::this_thread::yield()) hung = true;
    ++looks;
    return std::nullopt;
  }
  const vision::RangeView& see() override { return view_; }
  Eigen::Isometry3d left_from_view() const override { return Eigen::Isometry3d::Identity(); }
  const std::string& fault() const override { return fault_; }
  std::atomic<int> looks{0};
  std::atomic<bool> hang{false}, hung{false};

 private:
  vision::RangeView view_;
  std::string fault_;
};

/// No loop is thought to hang, however slow the machine is.
LiveConfig patient() {
  LiveConfig config;
  config.frames_hang = config.frames_end_within = config.rest_within = seconds(6000);
  return config;
}

LiveConfig soon_hanging() {
  LiveConfig config;
  config.frames_hang = seconds(1);
  config.frames_end_within = seconds(2);
  config.rest_within = seconds(2);
  return config;
}

class HangingBus final : public hal::CanBus {
 public:
  bool send(const hal::CanFrame&) noexcept override { return true; }
  std::size_t receive(std::span<hal::CanFrame>) noexcept override {
    if (hang) hung = true;
    hang.wait(true);
    return 0;
  }
  hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }
  std::atomic<bool> hang{false}, hung{false};
};

struct Bench {
  explicit Bench(const LiveConfig& config = soon_hanging()) : loops(config, clock, bus_loop, frames, links) {}

  hal::ScaledClock clock{0.1};
  HangingBus bus;
  FakeHead head;
  FakeWalker walker;
  Links links;
  ShutEyes eyes;
  Mapper mapper{small_map(), {}};
  Mission mission{{}, mapper.floor().grid};
  BusLoop bus_loop{{.stance = hal::Stance::parallel({}, 0.19), .steps = {}}, bus, head, walker, links};
  FrameLoop frames{{}, eyes, mapper, mission, links, clock};
  LiveLoops loops;
};

TEST(LiveLoops, RunBothLoopsUntilTheyAreStopped) {
  Bench bench;
  std::atomic<int> updates{0};
  bench.loops.on_update([&] { ++updates; });
  bench.loops.start();
  while (updates < 3) std::this_thread::yield();
  EXPECT_TRUE(bench.loops.stop()) << "the robot stands";
  EXPECT_FALSE(bench.loops.failure());
  EXPECT_GT(bench.bus_loop.counters().cycles, 3U);
  EXPECT_GT(bench.eyes.looks, 3);
  const auto cycles = bench.bus_loop.counters().cycles;
  EXPECT_TRUE(bench.loops.stop()) << "again";
  EXPECT_EQ(bench.bus_loop.counters().cycles, cycles);
}

TEST(LiveLoops, TellWhichOfThemHangs) {
  Bench bench;
  EXPECT_FALSE(bench.loops.hanging(bench.clock.now())) << "not started";
  bench.eyes.hang = true;
  bench.loops.start();
  EXPECT_FALSE(bench.loops.hanging(bench.clock.now()));
  const auto hanging_is = [&](bool expected) {
    const Time give_up = bench.clock.now() + seconds(300);
    auto hanging = bench.loops.hanging(bench.clock.now());
    while (hanging.has_value() != expected && bench.clock.now() < give_up) {
      bench.clock.sleep_until(bench.clock.now() + seconds(0.1));
      hanging = bench.loops.hanging(bench.clock.now());
    }
    return hanging.value_or("");
  };
  EXPECT_EQ(hanging_is(true).substr(0, 37), "the frame loop has not gone round for");
  bench.eyes.hang = false;
  EXPECT_EQ(hanging_is(false), "");
  bench.loops.stop();
  EXPECT_FALSE(bench.loops.hanging(bench.clock.now() + seconds(60))) << "stopped";
}

TEST(LiveLoops, BringTheRobotToRestAndEndThoughTheFrameLoopHangs) {
  Bench bench;
  bench.loops.start();
  while (bench.eyes.looks < 3) std::this_thread::yield();
  bench.eyes.hang = true;
  while (!bench.eyes.hung) std::this_thread::yield();
  EXPECT_TRUE(bench.loops.stop()) << "the robot stands";
  EXPECT_STREQ(bench.loops.left_hanging(), "frame");
  EXPECT_GT(bench.bus_loop.counters().cycles, 0U);
  bench.eyes.hang = false;
  EXPECT_TRUE(bench.loops.stop());
  EXPECT_STREQ(bench.loops.left_hanging(), "") << "it came back after all";
}

TEST(LiveLoops, DoNotWaitForABusThatNeverReturns) {
  Bench bench;
  bench.loops.start();
  while (bench.eyes.looks < 3) std::this_thread::yield();
  bench.bus.hang = true;
  while (!bench.bus.hung) std::this_thread::yield();
  EXPECT_FALSE(bench.loops.stop()) << "nothing is known of the robot";
  EXPECT_STREQ(bench.loops.left_hanging(), "bus");
  bench.bus.hang = false;
  bench.bus.hang.notify_all();
}

TEST(LiveLoops, KnowHowTheyKeepTime) {
  Bench bench(patient());
  EXPECT_EQ(bench.loops.figures().bus_run.count, 0U) << "not started";
  std::atomic<int> updates{0};
  bench.loops.on_update([&] { ++updates; });
  bench.loops.start();
  while (updates < 2) std::this_thread::yield();
  bench.loops.stop();
  ASSERT_STREQ(bench.loops.left_hanging(), "");
  const LoopFigures figures = bench.loops.figures();
  EXPECT_EQ(figures.bus_run.count, bench.bus_loop.counters().cycles);
  EXPECT_EQ(figures.bus_wake_up.count, figures.bus_run.count);
  EXPECT_GT(figures.bus_run.max, Duration(0));
  EXPECT_GE(figures.bus_wake_up.max, figures.bus_wake_up.p50);
  EXPECT_EQ(figures.frame_run.count, static_cast<std::uint64_t>(updates));
}

TEST(LiveLoops, DoNotBeginWithoutWhatIsEnforced) {
  ScriptedRealTime kernel;
  kernel.refuse_priority = EPERM;
  LiveConfig config;
  config.real_time = {.want = RealTime::Want::kEnforce, .bus_processor = {}, .calls = &kernel};
  Bench bench(config);
  EXPECT_THROW(bench.loops.start(), InputError);
  EXPECT_EQ(bench.bus_loop.counters().cycles, 0U);
  EXPECT_EQ(bench.eyes.looks, 0);
}

TEST(LiveLoops, AreStoppedBeforeTheyWereStarted) {
  Bench bench;
  EXPECT_FALSE(bench.loops.stop()) << "nothing is known of the robot";
}

}  // namespace
}  // namespace headway::runtime
