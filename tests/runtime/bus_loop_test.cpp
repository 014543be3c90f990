#include "runtime/bus_loop.h"

#include <algorithm>
#include <cstdlib>
#include <new>
#include <vector>

#include <gtest/gtest.h>

// heap_count.cpp
extern thread_local bool g_counting;
extern thread_local int g_allocations;

namespace headway::runtime {
namespace {

class SilentBus final : public hal::CanBus {
 public:
  bool send(const hal::CanFrame&) noexcept override { return true; }
  std::size_t receive(std::span<hal::CanFrame>) noexcept override { return 0; }
  hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }
};

class FakeHead final : public hal::Head {
 public:
  void receive(const hal::CanFrame&) noexcept override {}
  void tick(Time now) noexcept override { state_.stamp = now; }
  void command(const hal::HeadAngles& target) noexcept override { state_.target = target; }
  hal::HeadState state() const noexcept override { return state_; }

 private:
  hal::HeadState state_;
};

/// A control computer that accepts every step and takes 0.8 s for each.
class FakeWalker final : public hal::Walker {
 public:
  void receive(const hal::CanFrame&) noexcept override {}
  void tick(Time now) noexcept override {
    status_.stamp = now;
    if (request_ == hal::WalkRequest::kWalk && status_.state == hal::WalkState::kStanding &&
        session_ != status_.session) {
      status_.session = session_;
      status_.accepted = status_.executing = hal::kNoStep;
      steps_ = 0;
      started_ = 0;
    }
    if (steps_ > started_ && status_.state == hal::WalkState::kStanding && started_ == 0) begin_step(now);
    if (status_.state == hal::WalkState::kWalking) {
      if (now >= ends_) {
        if (steps_ > started_)
          begin_step(now);
        else
          status_.state = hal::WalkState::kStanding;
      }
      status_.phase_remaining = std::max(Duration(0), Duration(ends_ - now));
    }
  }
  bool send(std::uint8_t session, const hal::NumberedStep& step) noexcept override {
    if (session != status_.session) return false;
    if (sent_count < sent.size()) sent[sent_count++] = step;
    status_.accepted = static_cast<std::uint8_t>(step.index % 64);
    ++steps_;
    return true;
  }
  void control(hal::WalkRequest request, std::uint8_t session, Duration) noexcept override {
    request_ = request;
    session_ = session;
  }
  hal::WalkStatus status() const noexcept override { return status_; }
  hal::WalkerHealth health() const noexcept override { return hal::WalkerHealth::kReady; }
  hal::ChestSample chest() const noexcept override { return {}; }

  std::array<hal::NumberedStep, 64> sent{};
  std::size_t sent_count = 0;

 private:
  void begin_step(Time now) {
    status_.state = hal::WalkState::kWalking;
    status_.executing = static_cast<std::uint8_t>(started_++ % 64);
    ends_ = now + seconds(0.8);
  }
  hal::WalkStatus status_;
  hal::WalkRequest request_ = hal::WalkRequest::kNone;
  std::uint8_t session_ = 0;
  std::uint32_t steps_ = 0, started_ = 0;
  Time ends_{};
};

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
      loop.cycle(clock.now());
    }
    links.report.update();
  }
  /// Orders `count` straight steps from the next that is not committed.
  void order(int count, bool complete = true) {
    links.report.update();
    const nav::Committed& c = links.report.value().committed;
    MotionOrder order;
    order.number = ++orders;
    order.walk = MotionOrder::Walk::kPlan;
    order.plan.session = c.session;
    order.plan.first_index = c.next_index;
    order.plan.count = count;
    order.plan.complete = complete;
    order.plan.newest_frame = clock.now();
    for (int i = 0; i < count; ++i) {
      const bool left = (c.next_index + static_cast<std::uint32_t>(i)) % 2 == 0;
      order.plan.steps[static_cast<std::size_t>(i)] = {
          left ? hal::Foot::kLeft : hal::Foot::kRight, {0.1, left ? 0.19 : -0.19, 0}, 0, seconds(0.8)};
    }
    links.order.publish(order);
  }
  std::uint64_t orders = 0;
};

TEST(BusLoop, HandsOverThreeStepsAndThenOneForEachStepBegun) {
  Rig rig;
  rig.run(0.1);
  rig.order(3, false);
  rig.run(0.1);
  EXPECT_EQ(rig.walker.sent_count, 3U);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(rig.walker.sent[i].index, i);
  rig.order(5);
  rig.run(0.2);
  EXPECT_EQ(rig.walker.sent_count, 3U) << "step 3 commits only as step 0 comes to its end";
  rig.run(0.4);
  EXPECT_EQ(rig.walker.sent_count, 4U);
}

TEST(BusLoop, RecordsTheAgeOfTheFrameEachStepRestsUpon) {
  Rig rig;
  rig.run(0.1);
  rig.order(3);
  rig.run(0.1);
  StepRecord record;
  int records = 0;
  while (rig.links.steps.pop(record)) {
    EXPECT_GE(record.frame_age, Duration(0));
    EXPECT_LE(record.frame_age, seconds(0.1));
    EXPECT_EQ(record.step.index, static_cast<std::uint32_t>(records++));
  }
  EXPECT_EQ(records, 3);
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
  rig.order(20);
  rig.run(0.2);
  const auto session = rig.links.report.value().committed.session;
  MotionOrder stop;
  stop.number = 99;
  stop.walk = MotionOrder::Walk::kStop;
  rig.links.order.publish(stop);
  rig.run(5);
  EXPECT_EQ(rig.walker.sent_count, 3U);
  EXPECT_TRUE(rig.links.report.value().committed.at_rest);
  EXPECT_NE(rig.links.report.value().committed.session, session);
  EXPECT_EQ(rig.links.report.value().committed.next_index, 0U);
  EXPECT_NEAR(rig.links.report.value().committed.stance.base().x, 0.25, 1e-9) << "where the three steps led";
}

TEST(BusLoop, CountsCyclesThatDidNotComeInTime) {
  Rig rig;
  rig.run(0.05);
  rig.clock.advance(seconds(0.015));
  rig.loop.cycle(rig.clock.now());
  EXPECT_EQ(rig.loop.counters().missed, 2U);
}

TEST(BusLoop, UsesNoHeapInItsCycle) {
  Rig rig;
  rig.run(0.1);
  rig.order(10);
  g_counting = true;
  rig.run(3);
  g_counting = false;
  EXPECT_EQ(g_allocations, 0);
  g_counting = true;
  void* volatile proof = ::operator new(8);  // the counter does count
  g_counting = false;
  ::operator delete(proof);
  EXPECT_EQ(g_allocations, 1);
}

}  // namespace
}  // namespace headway::runtime
