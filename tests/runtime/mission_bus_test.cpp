// The mission with a bus loop and a robot that walks: its orders come late, and steps commit meanwhile.
#include <algorithm>
#include <deque>
#include <functional>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "runtime/bus_loop.h"
#include "tests/runtime/fake_robot.h"
#include "tests/runtime/mission_bench.h"

namespace headway::runtime {
namespace {

const Duration kCycle = seconds(0.005);
const Duration kFrame = seconds(0.1);

MissionConfig one_look() {
  MissionConfig config = hand_made();
  config.viewpoints = {{0, 0.5}};
  config.frames_per_view = 1;
  return config;
}

/// On its way to a place 3 m ahead, over a floor that is seen from above.
struct Walking {
  explicit Walking(Duration work_time, const MissionConfig& mission_config = one_look())
      : work(work_time), config(mission_config), mission(config, mapper.floor().grid) {
    mission.set_goal(kAhead);
  }

  /// One cycle of the bus, and the frame's work when there is time for it.
  void step() {
    clock.advance(kCycle);
    bus_loop.cycle(clock.now());
    if (busy && clock.now() >= done_at) {
      links.order.publish(order);
      busy = false;
    }
    if (busy || clock.now() < next_frame) return;
    next_frame = clock.now() + kFrame;
    done_at = clock.now() + work;
    busy = true;
    decide();
    if (after_frame) after_frame();
  }
  void run(double s) {
    for (const Time end = clock.now() + seconds(s); clock.now() < end;) step();
  }
  void until_committed(std::size_t steps) {
    for (int i = 0; i < 4000 && walker.sent_count < steps; ++i) step();
  }

  void decide() {
    const Eigen::Isometry3d from = from_above({1.7, 0}, 4.5);
    const Eigen::Isometry3d chest = walker.chest().odom_from_chest;
    if (blind.empty()) {
      mapper.integrate(look(boxes, from), from, chest, clock.now());
      mapper.project();
      last_look = clock.now();
    }
    links.report.update();
    order = mission.update({clock.now(), last_look, blind, false, true, order.look, chest, report(), mapper});
  }
  const BusReport& report() const { return links.report.value(); }

  Duration work;  ///< from a frame to its order
  MissionConfig config;
  Boxes boxes;
  std::string blind;
  hal::ManualClock clock;
  SilentBus bus;
  FakeHead head;
  FakeWalker walker;
  Links links;
  BusLoop bus_loop{{.stance = hal::Stance::parallel({}, 0.19), .steps = {}}, bus, head, walker, links};
  Mapper mapper{small_map(), {}};
  Mission mission;
  MotionOrder order;
  bool busy = false;
  Time next_frame{}, done_at{}, last_look = nav::kNever;
  std::function<void()> after_frame;
};

TEST(MissionOnTheBus, CommitsNothingMoreWhenTheGateHasShut) {
  MissionConfig config = one_look();
  config.gate.recent = seconds(0.15);
  Walking robot(seconds(0.02), config);
  robot.until_committed(4);
  ASSERT_EQ(robot.walker.sent_count, 4U);
  // The next step commits 0.8 s after this one, and the stack trusts a plan for a second.
  robot.run(0.3);
  robot.blind = "no light";
  robot.run(4);
  EXPECT_EQ(robot.walker.sent_count, 4U) << "what had been seen was no longer recent";
  EXPECT_TRUE(robot.report().committed.at_rest);
}

TEST(MissionOnTheBus, WalksNoPlanThatItHasDroppedBeforeTheWalkBegan) {
  Walking robot(Duration{});
  for (int i = 0; i < 4000 && robot.order.walk != Walk::kPlan; ++i) robot.step();
  ASSERT_EQ(robot.order.walk, Walk::kPlan);
  robot.walker.deaf = true;  // does not take up the session, so no step can be sent
  robot.run(0.3);
  robot.boxes = {box(0.3, 0.6, -2, 2, 1.2)};
  robot.run(1);
  robot.walker.deaf = false;
  robot.run(2);
  EXPECT_EQ(robot.walker.sent_count, 0U);
}

/// Judges a robot that walks: what its map shows when a frame is decided upon, and what is committed since.
class Judge {
 public:
  explicit Judge(Walking& robot) : robot_(robot), gate_(robot.config.gate, {}, robot.config.outline) {
    robot.after_frame = [this] { decided(); };
  }

  void step() {
    robot_.step();
    take_steps();
  }

  int threats = 0;        ///< frames that showed an obstacle on committed steps
  int walked_on = 0;      ///< of those, with another order than to stop
  int onto_obstacle = 0;  ///< steps committed onto what the map had shown for longer than the protocol needs

 private:
  struct Decided {
    Time holds_from;
    nav::FloorMap floor;
  };

  bool hit(const Pose2& base, const nav::FloorMap& floor) const { return gate_.hits({{base}}, floor); }

  void take_steps() {
    for (; seen_ < robot_.walker.sent_count; ++seen_) committed(robot_.walker.sent[seen_]);
  }

  void decided() {
    take_steps();  // of this cycle, which the mission was told of
    const nav::FloorMap& floor = robot_.mapper.floor();
    // In force one cycle after the work on it is done: that long the protocol needs.
    decided_.push_back({robot_.clock.now() + robot_.work + kCycle, floor});
    const bool threat =
        !robot_.report().committed.at_rest &&
        std::any_of(bases_.begin(), bases_.end(), [&](const Pose2& b) { return hit(b, floor); });
    threats += threat;
    walked_on += threat && robot_.order.walk != Walk::kStop;
  }

  /// The chain of the steps as the walker gets them; all of them are walked.
  void committed(const hal::NumberedStep& step) {
    while (decided_.size() > 1 && decided_[1].holds_from < robot_.clock.now()) decided_.pop_front();
    stance_ = stance_.after(step.step);
    const Pose2 base = nav::gait_base(stance_, step.step.foot, {});
    if (step.index == 0) bases_.clear();
    bases_.push_back(base);
    if (bases_.size() > 3) bases_.pop_front();
    onto_obstacle += decided_.front().holds_from < robot_.clock.now() && hit(base, decided_.front().floor);
  }

  Walking& robot_;
  FloorGate gate_;
  std::deque<Decided> decided_;
  std::deque<Pose2> bases_;  ///< of the newest three
  hal::Stance stance_ = hal::Stance::parallel({}, 0.19);
  std::size_t seen_ = 0;
};

TEST(MissionOnTheBus, CommitsNoStepOntoAnObstacleThatTheMapHadShown) {
  int threats = 0, late = 0;
  const bool kept = rc::check("no order comes too late, wherever and whenever an obstacle turns up", [&] {
    const auto some = [](int low, int high) { return *rc::gen::inRange(low, high + 1); };
    Walking robot(kCycle * some(0, 80));
    Judge judge(robot);
    const auto begun = static_cast<std::size_t>(some(3, 6));
    for (int i = 0; i < 4000 && robot.walker.sent_count < begun; ++i) judge.step();
    for (int i = some(0, 160); i > 0; --i) judge.step();
    const double x = robot.walker.stance.base().x + 0.01 * some(30, 130), y = 0.01 * some(-50, 50);
    robot.boxes = {box(x, x + 0.3, y, y + 0.3, 1.2)};
    for (int i = 0; i < 600; ++i) judge.step();
    threats += judge.threats > 0;
    late += robot.bus_loop.counters().plans_late > 0;
    RC_ASSERT(judge.onto_obstacle == 0);
    RC_ASSERT(judge.walked_on == 0);
  });
  EXPECT_TRUE(kept);
  EXPECT_GT(threats, 5);
  EXPECT_GT(late, 5);
}

}  // namespace
}  // namespace headway::runtime
