// The masters run within the bus cycle: once built they must not touch the heap, whatever comes in. Nor must
// cameras within the frame loop's, once their images have their size.
#include <gtest/gtest.h>

#include "drivers/stereo_pair.h"
#include "tests/drivers/camera_bench.h"
#include "tests/drivers/head_bench.h"
#include "tests/drivers/walker_bench.h"
#include "tests/heap_count.h"

namespace headway::drivers {
namespace {

std::uint64_t allocations = 0;

/// Counts what a master allocates, not what its scripted peers do.
template <class Master>
class Counted {
 public:
  explicit Counted(Master& master) : master_(master) {}
  template <class Call>
  auto operator()(Call call) {
    struct Count {
      std::uint64_t before = heap_allocations();
      ~Count() { allocations += heap_allocations() - before; }
    } count;
    return call(master_);
  }

 private:
  Master& master_;
};

TEST(HeapCount, SeesAnAllocation) {
  int unused = 0;
  Counted counted(unused);
  allocations = 0;
  // Called as a function, which no compiler may leave out; a new expression it may.
  ::operator delete(counted([](int&) { return ::operator new(1); }));
  EXPECT_EQ(allocations, 1U);
}

/// From the start to a fault and back, for ten seconds.
void expect_no_heap(const HeadConfig& config, bool homed) {
  testing::ScriptedBus bus;
  Cia402Head head(bus, config);
  Counted counted(head);
  testing::ScriptedDrive pan(0x11), tilt(0x12);
  pan.homed = homed;
  allocations = 0;
  std::size_t read = 0;
  bool was_ready = false, was_fault = false;
  Time now = at_seconds(1);
  for (int i = 0; i < 2000; ++i, now += testing::kBusCycle) {
    bus.now = now;
    for (testing::ScriptedDrive* drive : {&pan, &tilt}) {
      drive->tick(now);
      for (const hal::CanFrame& f : drive->out) counted([&](Cia402Head& h) { h.receive(f); });
      drive->out.clear();
    }
    counted([&](Cia402Head& h) {
      h.command({0.001 * (i % 500), -0.1});
      h.tick(now);
    });
    for (; read < bus.sent.size(); ++read) {
      pan.receive(bus.sent[read], now);
      tilt.receive(bus.sent[read], now);
    }
    if (i == 800) pan.boot(now);
    if (i == 1300) tilt.fault();
    if (i == 1500) head.recover();
    was_ready = was_ready || head.state().health == hal::HeadHealth::kReady;
    was_fault = was_fault || head.state().health == hal::HeadHealth::kFault;
  }
  EXPECT_TRUE(was_ready && was_fault);
  EXPECT_EQ(head.state().health, hal::HeadHealth::kReady);
  EXPECT_EQ(allocations, 0U);
}

TEST(Cia402Head, UsesNoHeapFromStartUpToFaultAndBack) { expect_no_heap({}, true); }

TEST(Cia402Head, UsesNoHeapWhereItIsHomedAndLedCyclically) {
  HeadConfig config;
  config.set_points = SetPointMode::kCyclic;
  config.homing = {.policy = HomingConfig::Policy::kMove, .method = 17};
  expect_no_heap(config, false);
}

TEST(CanWalker, UsesNoHeapWhateverComesIn) {
  testing::ScriptedBus bus;
  CanWalker walker(bus);
  Counted counted(walker);
  testing::ScriptedControl control;
  allocations = 0;
  std::size_t read = 0;
  std::uint32_t index = 0;
  Time now = at_seconds(1);
  for (int i = 0; i < 2000; ++i, now += testing::kBusCycle) {
    bus.now = now;
    control.tick(now);
    control.spoil_status = i % 100 > 90;
    for (const hal::CanFrame& f : control.out) counted([&](CanWalker& w) { w.receive(f); });
    control.out.clear();
    counted([&](CanWalker& w) {
      w.control(hal::WalkRequest::kWalk, 1, seconds(0.1));
      if (w.send(1, {index, testing::step_of(index)})) ++index;
      w.tick(now);
    });
    for (; read < bus.sent.size(); ++read) control.receive(bus.sent[read], now);
  }
  EXPECT_GT(control.accepted.size(), 100u);
  EXPECT_EQ(allocations, 0U);
}

TEST(StereoPair, UsesNoHeapFromTheThirdFrameOnNotEvenWhenACameraComesBack) {
  hal::ManualClock clock;
  clock.set(at_seconds(100));
  testing::ScriptedCalls calls(clock);
  StereoPairConfig config{testing::small_config(), testing::small_config(), {}};
  config.tolerance = std::chrono::milliseconds(20);  // it comes back out of step
  config.right.path = "/dev/right";
  calls.add(config.left.path, testing::ScriptedCamera(PixelFormat::kGrey));
  testing::ScriptedCamera& right = calls.add(config.right.path, testing::ScriptedCamera(PixelFormat::kGrey));
  StereoPair pair(config, clock, calls);
  Counted counted(pair);
  hal::StereoFrame frame;
  int taken = 0;
  for (int i = 0; i < 2000; ++i) {
    clock.advance(std::chrono::milliseconds(5));
    taken += counted([&](StereoPair& p) { return p.take_newest(frame); });
    if (taken == 2) {
      allocations = 0;
      calls.allocations = 0;
    }
    if (i == 500) right.unplug();
    if (i == 700) right.plug();
    if (i == 1200) right.frozen = true;
    if (i == 1400) right.frozen = false;
  }
  EXPECT_GT(taken, 150);
  EXPECT_EQ(pair.right().stats().gone, 1u);
  EXPECT_GT(pair.right().stats().restarts, 0u);
  EXPECT_EQ(allocations - calls.allocations, 0u);
}

}  // namespace
}  // namespace headway::drivers
