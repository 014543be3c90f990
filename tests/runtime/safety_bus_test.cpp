// Whatever a walk rests upon goes away, at any moment: the robot comes to rest in time, and does not start by
// itself.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/bus_loop.h"
#include "tests/runtime/fake_robot.h"

namespace headway::runtime {
namespace {

const Duration kCycle = seconds(0.005);
const Duration kRest = seconds(2.7);  // from when it is noticed

/// A robot that is told every tenth of a second to walk on, by a frame loop that never gives up a goal.
struct Bench {
  Bench() {
    walker.apart = hal::ClockOffset{};
    word.lease = 1;
    give_goal();
  }

  void cycle() {
    clock.advance(kCycle);
    const Time now = clock.now();
    if (renews) {
      word.renewed = now;
      links.operator_word.publish(word);
    }
    if (now >= next_order) order(now);
    loop.cycle(now, cycles);
    links.report.update();
  }
  void run(Duration d) {
    for (const Time end = clock.now() + d; clock.now() < end;) cycle();
  }
  void order(Time now) {
    next_order = now + seconds(0.1);
    const nav::Committed& c = links.report.value().committed;
    MotionOrder order;
    order.goal = goal && !ends;
    order.goal_after = goal_after;
    order.end = ends;
    if (pictures) seen = now;
    const bool placed = !head.silent && !walker.silent;
    if (pictures && sees && placed) looked = now;
    order.seen = seen;
    order.walk = MotionOrder::Walk::kPlan;
    order.plan.session = c.session;
    order.plan.first_index = c.next_index;
    order.plan.count = 10;
    order.plan.newest_frame = looked;
    for (std::uint32_t i = 0; i < 10; ++i) {
      const bool left = (c.next_index + i) % 2 == 0;
      order.plan.steps[i] = {
          left ? hal::Foot::kLeft : hal::Foot::kRight, {0.1, left ? 0.19 : -0.19, 0}, 0, seconds(0.8)};
    }
    if (pictures || ends) links.order.publish(order);
  }
  void give_goal() { goal_after = links.report.value().safety.stops; }
  const SafetyReport& safety() const { return links.report.value().safety; }
  bool rests() const { return walker.stands() && loop.committed().at_rest; }

  hal::ManualClock clock;
  SilentBus bus;
  FakeHead head;
  FakeWalker walker;
  std::unique_ptr<Links> links_ = std::make_unique<Links>();
  Links& links = *links_;
  BusLoop loop{{.stance = hal::Stance::parallel({}, 0.19), .steps = {}}, bus, head, walker, links};
  OperatorWord word;
  CycleHealth cycles = CycleHealth::kOnTime;
  bool renews = true, pictures = true, sees = true, goal = true, ends = false;
  std::uint32_t goal_after = 0;
  Time next_order{}, seen{}, looked{};
};

struct Loss {
  const char* name;
  std::function<void(Bench&, bool away)> set;
  double noticed;  ///< after so many seconds
  double lost;     ///< and after so many it does not go on by itself
};

const std::vector<Loss>& losses() {
  using hal::CanBusState;
  static const std::vector<Loss> all{
      {"bus off",
       [](Bench& b, bool away) {
         b.bus.is = away ? CanBusState::kBusOff : CanBusState::kErrorActive;
         b.walker.silent = b.head.silent = away;
       },
       0, 0},
      {"adapter gone",
       [](Bench& b, bool away) { b.bus.is = away ? CanBusState::kGone : CanBusState::kErrorActive; }, 0, 0},
      {"control computer silent", [](Bench& b, bool away) { b.walker.silent = away; }, 0.1, 0.11},
      {"control computer at fault", [](Bench& b, bool away) { b.walker.fault = away; }, 0.005, 0.005},
      {"its time unknown",
       [](Bench& b, bool away) {
         if (away) b.walker.apart.reset();
         if (!away) b.walker.apart = hal::ClockOffset{};
       },
       0, 0},
      {"drives at fault",
       [](Bench& b, bool away) { b.head.health = away ? hal::HeadHealth::kFault : hal::HeadHealth::kReady; },
       0, 0},
      {"drives boot",
       [](Bench& b, bool away) {
         b.head.health = away ? hal::HeadHealth::kStarting : hal::HeadHealth::kReady;
       },
       0, 0},
      {"link to the operator", [](Bench& b, bool away) { b.renews = !away; }, 1, 1.01},
      {"cycles fail",
       [](Bench& b, bool away) { b.cycles = away ? CycleHealth::kFailing : CycleHealth::kOnTime; }, 0, 0},
      {"the operator says stop", [](Bench& b, bool away) { b.word.stops += away; }, 0, 0},
      {"no pictures", [](Bench& b, bool away) { b.pictures = !away; }, 1, 3.2},
      {"nothing to be seen", [](Bench& b, bool away) { b.sees = !away; }, 1, 10.2},
      {"head's position", [](Bench& b, bool away) { b.head.silent = away; }, 1, 10.2}};
  return all;
}

/// In the middle of a walk.
std::unique_ptr<Bench> under_way(Duration later) {
  auto bench = std::make_unique<Bench>();
  bench->run(seconds(3.8) + later);
  EXPECT_EQ(bench->safety().state, SafetyState::kActive) << describe(bench->safety());
  EXPECT_FALSE(bench->rests());
  return bench;
}

/// A new goal, and what it takes besides.
void expect_to_walk_again(Bench& bench) {
  if (bench.safety().state == SafetyState::kFault) {
    bench.give_goal();
    bench.run(seconds(1));
    EXPECT_TRUE(bench.rests()) << "not before somebody has looked at it";
    ++bench.word.resets;
    bench.run(seconds(1));
    EXPECT_TRUE(bench.rests()) << "a goal from before";
  }
  ++bench.word.lease;  // control taken anew
  bench.run(seconds(0.1));
  EXPECT_TRUE(bench.rests());
  bench.give_goal();
  bench.run(seconds(1));
  EXPECT_FALSE(bench.rests()) << describe(bench.safety());
  EXPECT_EQ(bench.safety().state, SafetyState::kActive);
}

TEST(SafetyOnTheBus, VoidsAGoalThatCrossesAStopOnItsWay) {
  const auto bench = under_way({});
  ++bench->word.stops;
  bench->run(seconds(3));
  const std::uint32_t known = bench->safety().stops;
  ++bench->word.stops;
  bench->run(seconds(0.1));
  bench->goal_after = known;
  bench->run(seconds(2));
  EXPECT_TRUE(bench->rests()) << "though the robot was stopped already";
  bench->give_goal();
  bench->run(seconds(1));
  EXPECT_FALSE(bench->rests());
}

TEST(SafetyOnTheBus, VoidsAGoalThatWaitsWhenSomethingIsLost) {
  const auto bench = under_way({});
  ++bench->word.stops;
  bench->run(seconds(3));
  bench->sees = false;
  bench->run(seconds(1.5));
  bench->give_goal();
  bench->run(seconds(0.1));
  EXPECT_EQ(bench->safety().state, SafetyState::kInit) << "waits for pictures";
  bench->bus.is = hal::CanBusState::kBusOff;
  bench->run(seconds(0.1));
  bench->bus.is = hal::CanBusState::kErrorActive;
  bench->sees = true;
  bench->run(seconds(2));
  EXPECT_TRUE(bench->rests()) << "nothing starts by itself";
  bench->give_goal();
  bench->run(seconds(1));
  EXPECT_FALSE(bench->rests());
}

TEST(SafetyOnTheBus, RecoversTheHeadWhenSomebodyHasLookedAtIt) {
  Bench bench;
  bench.run(seconds(0.1));
  EXPECT_EQ(bench.head.recovered, 0);
  ++bench.word.resets;
  bench.run(seconds(0.1));
  EXPECT_EQ(bench.head.recovered, 1);
}

TEST(SafetyOnTheBus, BringsTheRobotToRestInTimeFromEveryMomentOfAStep) {
  for (const Loss& loss : losses()) {
    SCOPED_TRACE(loss.name);
    for (Duration later{}; later < seconds(0.8); later += seconds(0.02)) {
      SCOPED_TRACE(to_seconds(later));
      const auto bench = under_way(later);
      loss.set(*bench, true);
      const Time away = bench->clock.now(), noticed = away + seconds(loss.noticed) + 2 * kCycle;
      const std::uint32_t steps = bench->loop.committed().next_index;
      while (bench->clock.now() < noticed + kRest) {
        if (loss.noticed == 0) {
          ASSERT_LE(bench->loop.committed().next_index, steps);
        }
        bench->cycle();
      }
      ASSERT_TRUE(bench->walker.stands());
      const bool lost = bench->clock.now() - away > seconds(loss.lost);
      ASSERT_EQ(stopped(bench->safety().state), lost) << describe(bench->safety());
      ASSERT_EQ(bench->safety().state == SafetyState::kDegraded, !lost) << describe(bench->safety());
    }
  }
}

TEST(SafetyOnTheBus, NeverStartsByItselfWhenWhatWasLostIsBack) {
  for (const Loss& loss : losses()) {
    SCOPED_TRACE(loss.name);
    const auto bench = under_way({});
    loss.set(*bench, true);
    bench->run(seconds(12));
    ASSERT_TRUE(bench->walker.stands());
    ASSERT_EQ(bench->safety().state, bench->walker.fault ? SafetyState::kFault : SafetyState::kSafeStop)
        << describe(bench->safety());
    loss.set(*bench, false);
    bench->run(seconds(3));
    for (int i = 0; i < 4000; ++i) {
      bench->cycle();
      ASSERT_TRUE(bench->rests()) << describe(bench->safety());
    }
    expect_to_walk_again(*bench);
  }
}

TEST(SafetyOnTheBus, GoesOnByItselfOnlyFromWhatWasPoorAndNotLost) {
  int went_on = 0;
  for (const Loss& loss : losses()) {
    SCOPED_TRACE(loss.name);
    const auto bench = under_way({});
    loss.set(*bench, true);
    bench->run(seconds(2));
    loss.set(*bench, false);
    bench->run(seconds(8));
    const bool expected = loss.lost > 2;
    EXPECT_EQ(!bench->rests(), expected) << describe(bench->safety());
    went_on += expected;
  }
  EXPECT_EQ(went_on, 3);
}

TEST(SafetyOnTheBusSlow, KeepsItsPromisesWhenTwoThingsAreLostInAnyOrder) {
  int runs = 0;
  for (const Loss& one : losses()) {
    for (const Loss& other : losses()) {
      if (&one == &other) continue;
      SCOPED_TRACE(std::string(one.name) + ", then " + other.name);
      for (const double apart : {0.0, 0.05, 0.3, 0.9, 1.5, 3.5}) {
        for (const bool first_back_first : {true, false}) {
          const auto bench = under_way(seconds(0.1 * (runs++ % 8)));
          one.set(*bench, true);
          bench->run(seconds(apart));
          other.set(*bench, true);
          bench->run(seconds(std::max(one.noticed, other.noticed)) + 2 * kCycle + kRest);
          ASSERT_TRUE(bench->walker.stands()) << apart;
          bench->run(seconds(8));
          (first_back_first ? one : other).set(*bench, false);
          bench->run(seconds(1));
          (first_back_first ? other : one).set(*bench, false);
          bench->run(seconds(3));
          for (int i = 0; i < 1000; ++i) {
            bench->cycle();
            ASSERT_TRUE(bench->rests()) << describe(bench->safety());
          }
        }
      }
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(runs, 1500);
}

TEST(SafetyOnTheBus, BringsTheRobotToRestForGoodWhenTheProgramEnds) {
  const auto bench = under_way({});
  bench->ends = true;
  bench->run(kRest + seconds(0.1) + 2 * kCycle);
  EXPECT_TRUE(bench->rests());
  EXPECT_EQ(bench->safety().state, SafetyState::kSafeStop);
  bench->give_goal();
  bench->run(seconds(5));
  EXPECT_TRUE(bench->rests());
}

TEST(SafetyOnTheBus, TakesNoGoalFromAnOperatorWhoDidNotKnowOfTheStop) {
  const auto bench = under_way({});
  bench->walker.silent = true;
  bench->run(seconds(0.2));
  bench->walker.silent = false;
  bench->run(seconds(4));
  ASSERT_EQ(bench->safety().state, SafetyState::kSafeStop);
  EXPECT_EQ(bench->safety().source, SafetySource::kControl);
  bench->goal_after = 0;
  bench->run(seconds(5));
  EXPECT_TRUE(bench->rests());
  bench->give_goal();
  bench->run(seconds(1));
  EXPECT_FALSE(bench->rests());
}

TEST(SafetyOnTheBus, NeedsNoOperatorWhereNobodyEverHadControl) {
  Bench bench;
  bench.renews = false;
  bench.run(seconds(10));
  EXPECT_EQ(bench.safety().state, SafetyState::kActive);
  EXPECT_EQ(bench.safety().of(SafetySource::kOperator).level, SourceLevel::kUnused);
}

TEST(SafetyOnTheBus, BeginsNoWalkBeforeEverythingWasHeard) {
  for (const Loss& loss : losses()) {
    if (std::string(loss.name).find("operator") != std::string::npos) continue;
    if (std::string(loss.name).find("time") != std::string::npos) continue;
    SCOPED_TRACE(loss.name);
    Bench bench;
    loss.set(bench, true);
    bench.run(seconds(20));
    EXPECT_TRUE(bench.rests()) << describe(bench.safety());
    EXPECT_EQ(bench.walker.sent_count, 0U);
    EXPECT_EQ(bench.loop.counters().plans_taken, 0U);
    EXPECT_EQ(bench.loop.counters().stops, 0U);
  }
}

TEST(SafetyOnTheBus, CallsDrivesThatAreSetUpForTheFirstTimeNotLost) {
  Bench bench;
  bench.head.health = hal::HeadHealth::kStarting;
  bench.run(seconds(1));
  EXPECT_EQ(describe(bench.safety()), "head drives not heard yet");
  bench.head.health = hal::HeadHealth::kReady;
  bench.run(seconds(1));
  EXPECT_EQ(bench.safety().of(SafetySource::kDrives).lost, 0U);
  EXPECT_FALSE(bench.rests());
}

TEST(SafetyOnTheBus, BeginsNoWalkWhileSomethingIsPoor) {
  Bench bench;
  bench.sees = false;
  bench.run(seconds(0.5));
  bench.cycles = CycleHealth::kLate;
  bench.sees = true;
  bench.run(seconds(5));
  EXPECT_TRUE(bench.rests());
  bench.cycles = CycleHealth::kOnTime;
  bench.run(seconds(0.2));
  ASSERT_FALSE(bench.rests());
  bench.sees = false;  // the walk ends, the goal stands
  bench.run(seconds(4));
  ASSERT_TRUE(bench.rests());
  bench.sees = true;
  bench.cycles = CycleHealth::kLate;
  bench.run(seconds(4));
  EXPECT_EQ(bench.safety().state, SafetyState::kDegraded);
  EXPECT_TRUE(bench.rests());
  bench.cycles = CycleHealth::kOnTime;
  bench.run(seconds(0.2));
  EXPECT_FALSE(bench.rests());
}

TEST(SafetyOnTheBus, RestsWithoutAGoalAndNeedsNoStopToDoSo) {
  const auto bench = under_way({});
  bench->goal = false;
  bench->run(seconds(0.1) + kRest + 2 * kCycle);
  EXPECT_TRUE(bench->rests());
  EXPECT_EQ(bench->safety().state, SafetyState::kReady);
  EXPECT_EQ(bench->safety().stops, 0U);
  bench->run(seconds(5));
  EXPECT_TRUE(bench->rests());
  bench->goal = true;
  bench->run(seconds(0.5));
  EXPECT_FALSE(bench->rests());
}

TEST(SafetyOnTheBus, HoldsASecondFaultUntilThatIsResetAsWell) {
  const auto bench = under_way({});
  for (int i = 0; i < 2; ++i) {
    bench->walker.fault = true;
    bench->run(seconds(4));
    bench->walker.fault = false;
    bench->run(seconds(4));
    ASSERT_EQ(bench->safety().state, SafetyState::kFault);
    expect_to_walk_again(*bench);
  }
}

TEST(SafetyOnTheBus, StopsForAControlComputerThatBeganAnewOnTheWay) {
  const auto bench = under_way({});
  bench->walker.restart();
  bench->walker.deaf = true;  // says what it knows before it hears of a walk
  bench->run(seconds(0.04));
  bench->walker.deaf = false;
  bench->run(seconds(10));
  EXPECT_TRUE(bench->rests());
  EXPECT_EQ(bench->safety().state, SafetyState::kSafeStop);
  EXPECT_EQ(bench->safety().source, SafetySource::kControl);
}

TEST(SafetyOnTheBus, CountsWhatWasLostAndSaysWhy) {
  const auto bench = under_way({});
  for (int i = 0; i < 3; ++i) {
    bench->walker.silent = true;
    bench->run(seconds(0.2));
    bench->walker.silent = false;
    bench->run(seconds(4));
  }
  EXPECT_EQ(describe(bench->safety()), "control computer lost");
  EXPECT_EQ(bench->safety().of(SafetySource::kControl).lost, 3U);
  EXPECT_EQ(bench->safety().of(SafetySource::kBus).lost, 0U);
}

TEST(OperatorLease, CountsForGoodNoMoreOnceItWasGone) {
  OperatorLease lease;
  EXPECT_FALSE(lease.used());
  OperatorWord word{.lease = 3, .renewed = at_seconds(1)};
  lease.follow(word, at_seconds(1));
  EXPECT_EQ(lease.renewed(), at_seconds(1));
  lease.follow(word, at_seconds(5.9));
  EXPECT_FALSE(lease.gone());
  lease.follow(word, at_seconds(6.1));
  EXPECT_TRUE(lease.gone());
  word.renewed = at_seconds(6.2);
  lease.follow(word, at_seconds(6.2));
  EXPECT_TRUE(lease.gone());
  EXPECT_FALSE(lease.renewed());
  word.lease = 4;
  lease.follow(word, at_seconds(6.3));
  EXPECT_EQ(lease.renewed(), at_seconds(6.2));
  word.lease = 0;
  lease.follow(word, at_seconds(6.4));
  EXPECT_TRUE(lease.gone()) << "given back";
}

}  // namespace
}  // namespace headway::runtime
