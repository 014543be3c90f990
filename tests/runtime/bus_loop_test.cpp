#include "runtime/bus_loop.h"

#include <new>
#include <vector>

#include <gtest/gtest.h>

#include "tests/heap_count.h"
#include "tests/runtime/fake_robot.h"

namespace headway::runtime {
namespace {

struct Rig {
  hal::ManualClock clock;
  SilentBus bus;
  FakeHead head;
  FakeWalker walker;
  Links links;
  BusLoop loop{[] {
                 BusLoopConfig config;
                 config.stance = hal::Stance::parallel({}, 0.19);
                 return config;
               }(),
               bus, head, walker, links};

  void run(double s) {
    for (const Time end = clock.now() + seconds(s); clock.now() < end;) {
      clock.advance(seconds(0.005));
      loop.cycle(clock.now(), health);
    }
    links.report.update();
  }
  /// Orders `count` straight steps from the next that is not committed.
  void order(int count, bool complete = true) {
    links.report.update();
    const nav::Committed& c = links.report.value().committed;
    MotionOrder order;
    order.walk = MotionOrder::Walk::kPlan;
    order.plan.session = c.session;
    order.plan.first_index = c.next_index;
    order.plan.count = count;
    order.plan.complete = complete;
    order.plan.newest_frame = order.seen = clock.now();
    order.goal = true;
    order.goal_after = links.report.value().safety.stops;
    for (int i = 0; i < count; ++i) {
      const bool left = (c.next_index + static_cast<std::uint32_t>(i)) % 2 == 0;
      order.plan.steps[static_cast<std::size_t>(i)] = {
          left ? hal::Foot::kLeft : hal::Foot::kRight, {0.1, left ? 0.19 : -0.19, 0}, 0, seconds(0.8)};
    }
    links.order.publish(order);
    last = order;
  }
  /// What is left of a walk of so many steps is ordered anew with every frame, until it stops.
  void walk(double s, int count) {
    const auto session = links.report.value().committed.session;
    for (const Time end = clock.now() + seconds(s); clock.now() < end; run(0.05)) {
      const nav::Committed& c = links.report.value().committed;
      if (c.session == session && !c.stopping) order(count - static_cast<int>(c.next_index));
    }
  }
  MotionOrder last;
  CycleHealth health = CycleHealth::kOnTime;
};

TEST(BusLoop, HandsOverOneStepAndThenTwoWhileTheWeightIsShiftedAndOneForEachStepBegun) {
  Rig rig;
  rig.run(0.1);
  rig.walk(0.4, 9);
  EXPECT_EQ(rig.walker.sent_count, 1U);
  rig.walk(0.3, 9);
  EXPECT_EQ(rig.walker.sent_count, 2U) << "as if one step came before the first";
  rig.walk(0.5, 9);
  EXPECT_EQ(rig.walker.sent_count, 2U) << "step 2 commits only when step 0 has begun";
  rig.walk(0.3, 9);
  EXPECT_EQ(rig.walker.sent_count, 3U);
  rig.walk(0.8, 9);
  EXPECT_EQ(rig.walker.sent_count, 4U);
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(rig.walker.sent[i].index, i);
}

TEST(BusLoop, RecordsTheAgeOfTheFrameEachStepRestsUpon) {
  Rig rig;
  rig.run(0.1);
  rig.walk(3, 3);
  StepRecord record;
  int records = 0;
  while (rig.links.steps.pop(record)) {
    EXPECT_GE(record.frame_age, Duration(0));
    EXPECT_LE(record.frame_age, seconds(0.1));
    EXPECT_EQ(record.step.index, static_cast<std::uint32_t>(records++));
  }
  EXPECT_EQ(records, 3);
}

TEST(BusLoop, ReportsHowFarTheControlComputersClockIsAsLongAsThatIsKnown) {
  Rig rig;
  rig.walker.apart = {.offset = seconds(12), .uncertainty = seconds(0.005)};
  rig.run(0.1);
  ASSERT_TRUE(rig.links.report.value().control_clock);
  EXPECT_EQ(rig.links.report.value().control_clock->offset, seconds(12));
  rig.walker.apart.reset();
  rig.run(0.1);
  EXPECT_FALSE(rig.links.report.value().control_clock);
}

TEST(BusLoop, RecordsOnlyStepsThatTheRobotWalksAndWhereTheyLand) {
  Rig rig;
  rig.walker.refused = 2;
  rig.run(0.1);
  rig.walk(2.5, 5);
  rig.run(1);
  EXPECT_EQ(rig.walker.sent_count, 3U) << "all three were handed over";
  std::vector<StepRecord> records;
  for (StepRecord record; rig.links.steps.pop(record);) records.push_back(record);
  ASSERT_EQ(records.size(), 2U) << "and the third was refused";
  const BusReport& report = rig.links.report.value();
  EXPECT_EQ(report.last_stop, nav::StackStop::kRejected);
  EXPECT_EQ(report.last_reject, hal::StepReject::kReach);
  EXPECT_EQ(report.last_steps, 2U);
  EXPECT_EQ(records[0].landing.x, report.committed.stance.left.x);
  EXPECT_EQ(records[1].landing.x, report.committed.stance.right.x);
  EXPECT_NEAR(rig.walker.stance.base().x, report.committed.stance.base().x, 1e-9);

  rig.walker.refused = 1000000;
  rig.walk(4, 2);
  records.clear();
  for (StepRecord record; rig.links.steps.pop(record);) records.push_back(record);
  ASSERT_EQ(records.size(), 2U);
  EXPECT_NEAR(records[0].landing.x, 0.3, 1e-9) << "goes on from where the walk before ended";
}

TEST(BusLoop, TakesNothingFromAPlanThatComesTooLate) {
  Rig rig;
  rig.run(0.1);
  rig.order(10);
  const MotionOrder late = rig.last;
  rig.run(0.1);
  rig.links.order.publish(late);
  rig.run(0.1);
  EXPECT_EQ(rig.loop.counters().plans_taken, 1U);
  EXPECT_EQ(rig.loop.counters().plans_late, 1U);
  EXPECT_EQ(rig.walker.sent_count, 1U);
}

TEST(BusLoop, ComesToRestWhenNoNewFrameBacksTheSteps) {
  Rig rig;
  rig.run(0.1);
  rig.order(20);
  rig.run(20);
  EXPECT_LT(rig.walker.sent_count, 20U) << "the plan grew older than a second";
  EXPECT_TRUE(rig.links.report.value().committed.at_rest);
  EXPECT_EQ(rig.links.report.value().last_stop, nav::StackStop::kStale);
  EXPECT_EQ(rig.loop.counters().stops, 1U);
}

TEST(BusLoop, CommitsNothingMoreAfterAStopAndOpensANewSessionAtRest) {
  Rig rig;
  rig.run(0.1);
  rig.walk(1.6, 20);
  const auto session = rig.links.report.value().committed.session;
  MotionOrder stop;
  stop.walk = MotionOrder::Walk::kStop;
  rig.links.order.publish(stop);
  rig.run(5);
  EXPECT_EQ(rig.walker.sent_count, 3U);
  EXPECT_TRUE(rig.links.report.value().committed.at_rest);
  EXPECT_NE(rig.links.report.value().committed.session, session);
  EXPECT_EQ(rig.links.report.value().committed.next_index, 0U);
  EXPECT_NEAR(rig.links.report.value().committed.stance.base().x, 0.25, 1e-9) << "where the three steps led";
}

TEST(BusLoop, ComesToRestWhileTooManyCyclesAreMissed) {
  Rig rig;
  rig.run(0.1);
  rig.walk(1.6, 20);
  rig.health = CycleHealth::kLate;
  rig.walk(0.8, 20);
  const auto sent = rig.walker.sent_count;
  EXPECT_GT(sent, 3U) << "some may be missed";
  rig.health = CycleHealth::kFailing;
  rig.run(2.7);
  EXPECT_EQ(rig.walker.sent_count, sent) << "no step is committed any more";
  EXPECT_TRUE(rig.loop.stands());
  EXPECT_EQ(rig.links.report.value().last_stop, nav::StackStop::kAsked);
  rig.order(5);
  rig.run(1);
  EXPECT_TRUE(rig.loop.stands()) << "nor is a new walk begun";
  EXPECT_EQ(rig.loop.counters().stops, 1U);
  rig.health = CycleHealth::kOnTime;
  rig.order(5);
  rig.run(0.2);
  EXPECT_FALSE(rig.loop.stands());
}

TEST(BusLoop, StaysAtRestOnceItWasTakenThere) {
  Rig rig;
  rig.run(0.1);
  rig.order(20);
  rig.run(0.2);
  EXPECT_FALSE(rig.loop.stands());
  rig.loop.come_to_rest();
  rig.run(2.7);
  EXPECT_TRUE(rig.loop.stands());
  EXPECT_EQ(rig.walker.sent_count, 1U);
  rig.order(20);
  rig.run(2);
  EXPECT_TRUE(rig.loop.stands());
  EXPECT_EQ(rig.walker.sent_count, 1U);
}

TEST(BusLoop, UsesNoHeapInItsCycle) {
  Rig rig;
  rig.run(0.1);
  rig.order(10);
  const std::uint64_t before = heap_allocations();
  rig.run(3);
  EXPECT_EQ(heap_allocations(), before);
  void* volatile proof = ::operator new(8);  // the counter does count
  ::operator delete(proof);
  EXPECT_EQ(heap_allocations(), before + 1);
}

}  // namespace
}  // namespace headway::runtime
