#include "nav/step_stack.h"

#include <algorithm>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/heap_count.h"
#include "tests/nav/stack_and_peer.h"

namespace headway::nav {
namespace {

using hal::Stance;
using hal::WalkState;
using std::chrono::milliseconds;

TEST(StepStack, RefusesTimesThatNoWalkCouldBeLedBy) {
  EXPECT_NO_THROW(StepStack{});
  const auto refuses = [](Duration StepStackConfig::*member, Duration value) {
    StepStackConfig config;
    config.*member = value;
    EXPECT_THROW(StepStack{config}, InputError) << to_seconds(value);
  };
  refuses(&StepStackConfig::commit_from, seconds(0.18));  // earlier than commit_by
  refuses(&StepStackConfig::commit_by, seconds(0.16));    // too late to be sent
  refuses(&StepStackConfig::lead, seconds(-0.01));
  refuses(&StepStackConfig::known_after, seconds(0.81));  // another step has begun
  refuses(&StepStackConfig::shortest_step, {});
  refuses(&StepStackConfig::margin, seconds(-0.01));
  refuses(&StepStackConfig::max_map_age, {});
  refuses(&StepStackConfig::status_timeout, {});
  refuses(&StepStackConfig::start_timeout, {});
}

TEST(StepStack, CommitsOneStepAtRestAndOneMoreBeforeEachDeadline) {
  Walking w;
  EXPECT_EQ(w.plan(0, 20, false, 1), PlanVerdict::kTaken);
  w.cycle();
  EXPECT_EQ(w.next(), 1u);
  w.run(milliseconds(300));
  EXPECT_EQ(w.next(), 1u);
  EXPECT_EQ(w.peer.started, 1u);
  for (std::uint32_t next = 1; next < 12; ++next) {
    while (w.now < w.peer.lifted + kStep && w.next() == next) w.run_fresh(milliseconds(5));
    if (w.next() == next) w.run_fresh(milliseconds(200));
    const Duration left = w.peer.deadline(next) - w.now;
    EXPECT_EQ(w.next(), next + 1);
    EXPECT_LE(left, kWindow);
    EXPECT_GE(left, kWindow - milliseconds(90)) << "a plan comes every 30 ms";
  }
  EXPECT_EQ(w.fault, nullptr) << w.fault;
}

TEST(StepStack, CommitsNoStepWhileAPlanIsInTheMaking) {
  // Frames that are worked on nearly until the next one, at all times relative to the steps.
  for (const int period : {35, 65, 100}) {
    for (int offset = 0; offset < period; offset += 5) {
      Walking w;
      w.plan(0, 20, false, 0);
      w.run(milliseconds(400 + offset));
      for (int frame = 0; frame < 100; ++frame) {
        const std::uint32_t first = w.next();
        const Time exposure = w.now;
        w.run(milliseconds(period - 5));
        ASSERT_EQ(w.propose(some_plan(first, 20, false, exposure)), PlanVerdict::kTaken)
            << "frame " << frame << " of every " << period << " ms, " << offset << " ms later";
        w.run(milliseconds(5));
      }
      EXPECT_EQ(w.fault, nullptr) << w.fault;
      EXPECT_GT(w.peer.started, period / 10u);
    }
  }
}

TEST(StepStack, DoesNotWaitForAPlanThatDoesNotCome) {
  Walking w;
  w.plan(0, 20, false, 0);
  w.run(milliseconds(100));
  for (int i = 0; i < 400 && w.next() == 1; ++i) w.cycle();
  EXPECT_EQ(w.next(), 2u);
  const Duration left = w.peer.deadline(1) - w.now;
  EXPECT_LT(left, kWindow - milliseconds(100)) << "the time that one frame takes";
  EXPECT_GT(left, kLead + milliseconds(20));
  EXPECT_EQ(w.fault, nullptr) << w.fault;
}

TEST(StepStack, CountsOnWhenTheNumbersOnTheWireBeginAgain) {
  Walking w;
  w.run_fresh(seconds(0.8 * 150));
  EXPECT_GT(w.next(), 140u);
  EXPECT_FALSE(w.stack.committed().stopping);
  EXPECT_EQ(w.fault, nullptr) << w.fault;
}

TEST(StepStack, EndsWithThePlan) {
  for (int count = 1; count < 7; ++count) {
    Walking w;
    EXPECT_EQ(w.plan(0, count, true, 1), PlanVerdict::kTaken);
    for (int frame = 0; frame < 300; ++frame) {
      const int left = count - static_cast<int>(w.next());
      if (!w.stack.committed().stopping) w.plan(w.next(), left, true, static_cast<int>(w.next()) + 1);
      w.run(milliseconds(30));
    }
    EXPECT_EQ(w.next(), static_cast<std::uint32_t>(count));
    EXPECT_EQ(w.peer.started, static_cast<std::uint32_t>(count));
    EXPECT_TRUE(w.stack.committed().at_rest);
    EXPECT_EQ(w.stack.committed().why, StackStop::kNone);
    EXPECT_EQ(w.fault, nullptr) << w.fault;
    EXPECT_EQ(w.plan(w.next(), 5, false, 1), PlanVerdict::kStopping);
    EXPECT_TRUE(w.stack.begin(kSession + 1, w.stack.committed().stance));
  }
}

TEST(StepStack, TakesTheNewestPlanForWhatIsNotCommitted) {
  Walking w;
  w.plan(0, 20, false, 0);
  w.run(milliseconds(100));
  EXPECT_EQ(w.plan(1, 20, false, 50), PlanVerdict::kTaken);
  EXPECT_EQ(w.plan(1, 20, false, 70), PlanVerdict::kTaken);
  w.run(milliseconds(800));
  ASSERT_EQ(w.next(), 2u);
  EXPECT_NEAR(w.committed[0].landing.x, 0.000, 1e-9);
  EXPECT_NEAR(w.committed[1].landing.x, 0.070, 1e-9);
}

TEST(StepStack, SaysWhyItRefusesAPlan) {
  Walking w;
  w.plan(0, 20, false, 0);
  w.run(milliseconds(100));
  EXPECT_EQ(w.plan(0, 20, false, 0), PlanVerdict::kLate);
  EXPECT_EQ(w.plan(2, 20, false, 0), PlanVerdict::kGap);
  StepPlan other = some_plan(1, 4, false, w.now);
  other.session = kSession + 1;
  EXPECT_EQ(w.stack.propose(other), PlanVerdict::kSession);
  StepPlan hop = some_plan(1, 4, false, w.now);
  hop.steps[1].foot = hop.steps[0].foot;
  EXPECT_EQ(w.stack.propose(hop), PlanVerdict::kInvalid);
  StepPlan same_foot = some_plan(1, 4, false, w.now);
  same_foot.steps[0].foot = hal::Foot::kLeft;  // as step 0
  EXPECT_EQ(w.stack.propose(same_foot), PlanVerdict::kInvalid);
  StepPlan long_plan = some_plan(1, 4, false, w.now);
  long_plan.count = StepPlan::kMost + 1;
  EXPECT_EQ(w.stack.propose(long_plan), PlanVerdict::kInvalid);
  w.stack.stop();
  EXPECT_EQ(w.plan(1, 4, false, 0), PlanVerdict::kStopping);
  EXPECT_EQ(w.stack.committed().taken, 1u);
  EXPECT_EQ(w.stack.committed().late, 1u);
  EXPECT_EQ(w.stack.committed().refused, 6u);
}

TEST(StepStack, BeginsOnlyAtRestAndWithAnotherSession) {
  Walking w;
  const Stance stance = Stance::parallel({1, 2, 3}, 0.19);
  EXPECT_FALSE(w.stack.begin(kSession, stance));
  EXPECT_FALSE(w.stack.begin(16, stance));
  w.plan(0, 20, false, 0);
  w.run(milliseconds(100));
  EXPECT_FALSE(w.stack.begin(kSession + 1, stance));
  w.stack.stop();
  w.run(seconds(4));
  EXPECT_TRUE(w.stack.begin(kSession + 1, stance));
  EXPECT_EQ(w.next(), 0u);
  EXPECT_EQ(w.stack.committed().stance.left.x, stance.left.x);
}

TEST(StepStack, StopsAtTheDeadlineForWantOfAStepOrOfFreshFrames) {
  Walking dry;
  for (int frame = 0; frame < 170; ++frame) {
    if (dry.next() < 3) dry.plan(dry.next(), 3 - static_cast<int>(dry.next()), false, 0);
    dry.run(milliseconds(30));
  }
  EXPECT_EQ(dry.stack.committed().why, StackStop::kMissed);
  EXPECT_EQ(dry.next(), 3u);
  EXPECT_TRUE(dry.stack.committed().at_rest);
  EXPECT_FALSE(dry.stack.committed().last_foot);
  Walking blind;
  blind.plan(0, 20, false, 0);
  blind.run(seconds(6));
  EXPECT_EQ(blind.stack.committed().why, StackStop::kStale);
  EXPECT_TRUE(blind.stack.committed().at_rest);
  EXPECT_EQ(blind.fault, nullptr) << blind.fault;
}

TEST(StepStack, IsAtRestAtMostTheStepsAheadAfterALossIsNoticed) {
  // Nothing heard any more: the step under way and two more, the last one just committed.
  for (int walked = 50; walked < 3800; walked += 10) {
    Walking w;
    w.run_fresh(milliseconds(walked));
    w.answers = false;
    for (int i = 0; i < 200 && !w.stack.committed().stopping; ++i) w.run_fresh(milliseconds(5));
    ASSERT_TRUE(w.stack.committed().stopping);
    const Time noticed = w.now;
    for (int i = 0; i < 2000 && !w.peer.standing; ++i) w.cycle();
    EXPECT_LE(w.now - noticed, seconds(2.4)) << "then the weight settles for 0.3 s";
    EXPECT_EQ(w.fault, nullptr) << w.fault;
  }
}

TEST(StepStack, ForgetsWhatThePeerRefusedOrNeverWalked) {
  Walking w;
  w.run_fresh(seconds(2));
  w.listens = false;  // no step arrives any more
  w.run_fresh(seconds(5));
  EXPECT_TRUE(w.stack.committed().at_rest);
  EXPECT_EQ(w.next(), w.peer.started);
  EXPECT_EQ(w.fault, nullptr) << w.fault;
}

TEST(StepStack, RemembersTheStepsBeforeThoseThatItForgets) {
  for (int into_step = 0; into_step < 800; into_step += 10) {
    Walking w;
    w.run_fresh(seconds(9) + milliseconds(into_step));  // more steps than are remembered
    w.listens = false;
    w.run_fresh(milliseconds(900));
    w.peer.refuses = w.listens = true;
    w.run_fresh(seconds(3));
    EXPECT_LT(w.next(), w.high) << "nothing was forgotten";
    EXPECT_EQ(w.fault, nullptr) << w.fault;
  }
}

TEST(StepStack, KnowsAControlComputerThatBeganAnewOnTheWay) {
  Walking w;
  w.run_fresh(seconds(3));
  w.heard.session = 0;
  w.heard.executing = w.heard.accepted = hal::kNoStep;
  w.heard.state = WalkState::kStanding;
  w.heard.stamp = w.now;
  EXPECT_FALSE(w.stack.due(w.now, w.heard));
  EXPECT_EQ(w.stack.committed().why, StackStop::kRestarted);
  EXPECT_TRUE(w.stack.committed().at_rest) << "so that another walk may begin";
}

TEST(StepStack, GivesUpAWalkThatNeverBegins) {
  Walking w;
  w.listens = false;
  w.run_fresh(seconds(5));
  EXPECT_EQ(w.stack.committed().why, StackStop::kNoStart);
  EXPECT_TRUE(w.stack.committed().at_rest);
  EXPECT_EQ(w.next(), 0u);
  EXPECT_EQ(w.stack.committed().stance.left.y, 0.095);
}

TEST(StepStack, WaitsAtRestForAFreshPlanAndStopsOnAFault) {
  Walking w;
  w.stack.propose(some_plan(0, 5, false, w.now - seconds(2)));
  w.run(milliseconds(200));
  EXPECT_EQ(w.next(), 0u);
  EXPECT_FALSE(w.stack.committed().stopping);
  w.run_fresh(seconds(3));
  EXPECT_GT(w.next(), 3u);
  w.heard.state = WalkState::kFault;
  w.heard.stamp = w.now;
  EXPECT_FALSE(w.stack.due(w.now, w.heard));
  EXPECT_EQ(w.stack.committed().why, StackStop::kLost);
}

TEST(StepStack, HandsTheSameStepOverUntilTheWalkerTakesIt) {
  Walking w;
  w.sends = false;
  w.plan(0, 20, false, 0);
  w.run(milliseconds(50));
  EXPECT_EQ(w.next(), 0u);
  w.stack.propose(some_plan(0, 4, false, w.now, 7));
  w.stack.sent(w.now);  // of the plan before: nothing is due from this one yet
  EXPECT_EQ(w.next(), 0u);
  w.sends = true;
  w.run(milliseconds(20));
  EXPECT_EQ(w.next(), 1u);
  EXPECT_NEAR(w.committed[0].landing.x, 0.007, 1e-9);
}

/// All orders of what can happen in each of `depth` stretches of time, from one situation.
class Exhaustion {
 public:
  explicit Exhaustion(Duration stretch) : stretch_(stretch) {}

  void explore(const Walking& from, int depth) {
    if (depth == 0 || from.fault != nullptr) {
      finish(from);
      return;
    }
    for (int event = 0; event < kEvents; ++event) {
      Walking w = from;
      happen(w, event, depth);
      explore(w, depth - 1);
    }
  }

  std::uint64_t ends = 0, stops = 0, walks = 0;
  std::map<StackStop, std::uint64_t> reasons;

 private:
  static constexpr int kEvents = 9;

  void happen(Walking& w, int event, int mark) const {
    w.answers = w.listens = w.sends = true;
    switch (event) {
      case 0:  // frames go on
        w.plan(w.next(), 20, false, mark);
        break;
      case 1:  // the plan that ends here soon
        w.plan(w.next(), 1, true, mark + 20);
        break;
      case 2:  // a plan that comes too late
        if (w.next() > 0 && w.plan(w.next() - 1, 20, false, mark) == PlanVerdict::kTaken)
          w.complain("late taken");
        break;
      case 3:  // no frame, no plan
        break;
      case 4:  // status frames are lost
        w.plan(w.next(), 20, false, mark + 40);
        w.answers = false;
        break;
      case 5:  // step frames are lost
        w.plan(w.next(), 20, false, mark + 60);
        w.listens = false;
        break;
      case 6:  // the driver has no room
        w.plan(w.next(), 20, false, mark + 80);
        w.sends = false;
        break;
      case 7:
        w.stack.stop();
        break;
      case 8:  // the peer refuses what comes, and another walk is asked for meanwhile
        w.peer.refuses = true;
        if (w.stack.begin(kSession, Stance{})) w.complain("began the same session again");
        break;
    }
    w.run(stretch_);
  }

  /// Left alone, every walk comes to rest, on the steps that the stack says.
  void finish(Walking w) {
    ++ends;
    w.answers = w.listens = w.sends = true;
    w.stack.stop();
    w.run(seconds(4.5));
    const Committed& c = w.stack.committed();
    if (!c.at_rest) w.complain("does not come to rest");
    if (c.next_index != w.peer.started) w.complain("other steps than were walked");
    ++reasons[c.why];
    walks += c.next_index > 3;
    if (w.fault != nullptr) ADD_FAILURE() << w.fault << " after " << c.next_index << " steps";
  }

  Duration stretch_;
};

TEST(StepStack, KeepsItsPromisesInEveryOrderOfEvents) {
  struct Situation {
    const char* name;
    Duration walked, stretch;
  };
  // At rest; before, in and after the window in which a step commits; over several steps.
  const Situation situations[] = {{"at rest", Duration{}, milliseconds(110)},
                                  {"while the weight is shifted", milliseconds(450), milliseconds(60)},
                                  {"before the window", milliseconds(2050), milliseconds(60)},
                                  {"in the window", milliseconds(2150), milliseconds(60)},
                                  {"across steps", milliseconds(1800), milliseconds(370)}};
  std::map<StackStop, std::uint64_t> reasons;
  std::uint64_t ends = 0, walks = 0;
  for (const Situation& s : situations) {
    SCOPED_TRACE(s.name);
    Walking w;
    w.run_fresh(s.walked);
    ASSERT_EQ(w.fault, nullptr) << w.fault;
    Exhaustion all(s.stretch);
    all.explore(w, 4);
    if (HasFailure()) return;
    ends += all.ends;
    walks += all.walks;
    for (const auto& [why, count] : all.reasons) reasons[why] += count;
  }
  EXPECT_EQ(ends, std::size(situations) * 9 * 9 * 9 * 9);
  EXPECT_GT(walks, ends / 10);
  for (const StackStop why :
       {StackStop::kNone, StackStop::kAsked, StackStop::kMissed, StackStop::kRejected, StackStop::kLost}) {
    EXPECT_GT(reasons[why], 0u) << static_cast<int>(why);
  }
}

TEST(StepStack, TakesNothingFromTheHeap) {
  const std::uint64_t before_vector = heap_allocations();
  std::vector<int> counted(10);
  ASSERT_GT(heap_allocations(), before_vector) << "the counter does not count";
  Walking w;
  const std::uint64_t before = heap_allocations();
  w.run_fresh(seconds(3));
  w.stack.stop();
  w.run(seconds(4));
  w.stack.begin(kSession + 1, w.stack.committed().stance);
  EXPECT_EQ(heap_allocations(), before);
}

}  // namespace
}  // namespace headway::nav
