// Both loops on their threads, with a robot as simple as can be and eyes that show nothing.
#include "runtime/live_loops.h"

#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "tests/runtime/fake_robot.h"
#include "tests/runtime/flat_room.h"

namespace headway::runtime {
namespace {

class ShutEyes final : public Eyes {
 public:
  std::optional<FrameStamp> take() override {
    while (hang) std::this_thread::yield();
    ++looks;
    return std::nullopt;
  }
  const vision::RangeView& see() override { return view_; }
  Eigen::Isometry3d left_from_view() const override { return Eigen::Isometry3d::Identity(); }
  const std::string& fault() const override { return fault_; }
  std::atomic<int> looks{0};
  std::atomic<bool> hang{false};

 private:
  vision::RangeView view_;
  std::string fault_;
};

struct Bench {
  hal::ScaledClock clock{0.1};
  SilentBus bus;
  FakeHead head;
  FakeWalker walker;
  Links links;
  ShutEyes eyes;
  Mapper mapper{small_map(), {}};
  Mission mission{{}, mapper.floor().grid};
  BusLoop bus_loop{{.stance = hal::Stance::parallel({}, 0.19), .steps = {}}, bus, head, walker, links};
  FrameLoop frames{{}, eyes, mapper, mission, links, clock};
  LiveLoops loops{{.frames_hang = seconds(1)}, clock, bus_loop, frames, links};
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

TEST(LiveLoops, AreStoppedBeforeTheyWereStarted) {
  Bench bench;
  EXPECT_FALSE(bench.loops.stop()) << "nothing is known of the robot";
}

}  // namespace
}  // namespace headway::runtime
