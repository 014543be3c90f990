// What the bus loop's cycle must never do, around the real masters and the simulated robot's bus: take memory
// from the heap, take a lock that may block, wait for a page.
#include <mutex>
#include <new>

#include <gtest/gtest.h>
#include <sys/mman.h>

#include "drivers/can_walker.h"
#include "drivers/cia402_head.h"
#include "runtime/bus_loop.h"
#include "runtime/page_faults.h"
#include "sim_hal/robot.h"
#include "tests/heap_count.h"
#include "tests/lock_count.h"

namespace headway::runtime {
namespace {

struct Sins {
  std::uint64_t heap = 0, locks = 0;
  PageFaults faults;
};

/// The head's master, and what a test has it do besides.
class MeddledHead final : public hal::Head {
 public:
  explicit MeddledHead(hal::CanBus& bus) : head_(bus, {}) {}
  void receive(const hal::CanFrame& frame) noexcept override { head_.receive(frame); }
  void tick(Time now) noexcept override {
    if (meddle != nullptr) meddle();
    head_.tick(now);
  }
  void command(const hal::HeadAngles& target) noexcept override { head_.command(target); }
  hal::HeadState state() const noexcept override { return head_.state(); }
  void recover() noexcept override { head_.recover(); }
  void (*meddle)() = nullptr;

 private:
  drivers::Cia402Head head_;
};

/// A robot that is switched on, looks about, walks, meets faults and walks again.
class BusCycle : public testing::Test {
 protected:
  static sim::RobotConfig with_faults() {
    using sim::FaultKind;
    sim::RobotConfig config;
    config.frame_rate = 0;
    config.faults = {{.kind = FaultKind::kCanLoss, .begin = seconds(8), .length = seconds(2)},
                     {.kind = FaultKind::kRebootPan, .begin = seconds(16)},
                     {.kind = FaultKind::kSilentControl, .begin = seconds(22), .length = seconds(0.5)},
                     {.kind = FaultKind::kBusOff, .begin = seconds(30), .length = seconds(0.5)},
                     {.kind = FaultKind::kCanCorruption, .begin = seconds(36), .length = seconds(0.2)}};
    return config;
  }

  /// Twenty straight steps from the first that is not committed, and another look; from somebody who looks
  /// at faults and gives the goal anew.
  void order() {
    links.report.update();
    if (links.report.value().head.health == hal::HeadHealth::kFault) {
      ++word.resets;
      links.operator_word.publish(word);
    }
    const nav::Committed& c = links.report.value().committed;
    MotionOrder order;
    order.walk = MotionOrder::Walk::kPlan;
    order.look = {0.3 * static_cast<double>(now.time_since_epoch() / seconds(1) % 3 - 1), 0.4};
    order.seen = now;
    order.goal = true;
    order.goal_after = links.report.value().safety.stops;
    order.plan.session = c.session;
    order.plan.first_index = c.next_index;
    order.plan.count = 20;
    order.plan.newest_frame = now;
    const bool left_first = c.last_foot ? *c.last_foot == hal::Foot::kRight : true;
    for (std::size_t i = 0; i < 20; ++i) {
      const bool left = (i % 2 == 0) == left_first;
      order.plan.steps[i] = {
          left ? hal::Foot::kLeft : hal::Foot::kRight, {0.1, left ? 0.19 : -0.19, 0}, 0, seconds(0.8)};
    }
    links.order.publish(order);
  }

  Sins cycles(double s) {
    Sins sins;
    for (const Time end = now + seconds(s); now < end;) {
      now += sim::SimRobot::kPeriod;
      robot.step(now);
      if (now.time_since_epoch() % seconds(0.1) == Duration(0)) order();
      const std::uint64_t heap = heap_allocations(), locks = locks_taken();
      const PageFaults faults = page_faults();
      loop.cycle(now);
      const PageFaults more = page_faults() - faults;
      sins.heap += heap_allocations() - heap;
      sins.locks += locks_taken() - locks;
      sins.faults.major += more.major;
      sins.faults.minor += more.minor;
    }
    return sins;
  }

  Time now{};
  OperatorWord word;
  sim::SimRobot robot{with_faults(), Pose2{}};
  MeddledHead head{robot.bus()};
  drivers::CanWalker walker{robot.bus()};
  Links links;
  BusLoop loop{{.stance = hal::Stance::parallel({}, 0.19), .steps = {}}, robot.bus(), head, walker, links};
};

TEST_F(BusCycle, TakesNeitherHeapNorLocksFromTheFirstOneOn) {
  const Sins sins = cycles(45);
  EXPECT_EQ(sins.heap, 0U);
  EXPECT_EQ(sins.locks, 0U);
  EXPECT_GT(walker.status().stamp, now - seconds(0.1)) << "the bus works";
  EXPECT_GT(robot.path_walked(), 2) << "and the robot has walked";
  EXPECT_GE(loop.counters().stops, 2U) << "and met faults";
}

TEST_F(BusCycle, WaitsForNoPageOnceItWasAllThereBefore) {
  cycles(12);  // code and data come with their first use, unless memory is locked
  const Sins sins = cycles(2);
  EXPECT_GT(robot.path_walked(), 0.5);
  EXPECT_EQ(sins.faults.major, 0U);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose own memory comes page by page
  EXPECT_EQ(sins.faults.minor, 0U);
#endif
}

TEST_F(BusCycle, IsCaughtAtEach) {
  cycles(1);
  head.meddle = [] { ::operator delete(::operator new(8)); };
  EXPECT_GE(cycles(0.1).heap, 20U);
  head.meddle = [] {
    static std::mutex mutex;
    const std::scoped_lock lock(mutex);
  };
  EXPECT_EQ(cycles(0.1).locks, 20U);
  head.meddle = [] {
    void* page = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    *static_cast<volatile char*>(page) = 1;
    ::munmap(page, 4096);
  };
  EXPECT_GE(cycles(0.1).faults.minor, 20U);
}

}  // namespace
}  // namespace headway::runtime
