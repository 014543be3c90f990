// Planner, feet and step stack at work for very long, on a floor where things come and go and with all that
// can happen on the way. HEADWAY_SOAK_EVENTS says for how long; without it, for as long as a test should
// take.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <malloc.h>

#include "hal/step_number.h"
#include "nav/footsteps.h"
#include "nav/planner.h"
#include "tests/nav/random_floor.h"
#include "tests/nav/stack_and_peer.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using std::chrono::milliseconds;

constexpr int kEdge = 110;             // cells of the floor, along both sides
constexpr std::size_t kMostBoxes = 9;  // that stand on it at the same time

/// Bytes taken from the heap and not given back.
std::size_t heap_in_use() { return mallinfo2().uordblks + mallinfo2().hblkhd; }

class Soak {
 public:
  explicit Soak(std::uint64_t seed) : dice_(seed) {}

  void event() {
    ++events;
    if (at_end()) begin_walk();
    walking_.answers = walking_.listens = walking_.sends = true;
    switch (dice_.whole(0, 40)) {
      case 0:
        move_something();
        break;
      case 1:
        plan();
        break;
      case 2:
        if (dice_.whole(0, 8) == 0) goal_ = some_goal();
        break;
      case 3:
        propose_late();
        break;
      case 4:  // no frame, no plan
        break;
      case 5:
        propose();
        walking_.answers = false;
        break;
      case 6:
        propose();
        walking_.listens = false;
        break;
      case 7:
        propose();
        walking_.sends = false;
        break;
      case 8:
        if (dice_.whole(0, 8) == 0) walking_.stack.stop();
        break;
      case 9:
        if (dice_.whole(0, 8) == 0) walking_.peer.refuses = true;
        break;
      default:  // frames go on
        propose();
    }
    walking_.run(milliseconds(5 * dice_.whole(1, 12)));
    if (walking_.fault != nullptr) ADD_FAILURE() << walking_.fault << ", event " << events;
  }

  std::uint64_t events = 0, walks = 0, steps = 0, plans = 0, found = 0, late = 0, compared = 0;

 private:
  bool at_end() const {
    const Committed& c = walking_.stack.committed();
    return c.at_rest && (c.stopping || c.next_index > 0 || left() == 0);
  }

  /// Steps of the walk that was planned last that are not committed.
  std::size_t left() const {
    const std::size_t done = walking_.next() - std::min(first_, walking_.next());
    return walk_.steps.size() - std::min(done, walk_.steps.size());
  }

  void begin_walk() {
    const Committed& c = walking_.stack.committed();
    steps += c.next_index;
    ++walks;
    goal_ = some_goal();
    begin(hal::Stance(c.stance));
    // A robot that cannot go from where it is gets set down elsewhere.
    for (int trial = 0; walk_.steps.empty() && trial < 20; ++trial) {
      const Vector2d place = some_place();
      begin(hal::Stance::parallel({place.x(), place.y(), dice_.real(-3, 3)}, gait_.feet_apart));
    }
    propose();
  }

  void begin(const hal::Stance& stance) {
    const int last = walking_.stack.committed().session;
    walking_.begin(static_cast<std::uint8_t>((last + 1) % (hal::kLastSession + 1)), stance);
    plan();
  }

  /// Another box, or one less.
  void move_something() {
    if (boxes_.size() < kMostBoxes && dice_.whole(0, 2) == 0) {
      const Vector2i low(dice_.whole(0, kEdge), dice_.whole(0, kEdge));
      boxes_.push_back({low, low + Vector2i(dice_.whole(0, 9), dice_.whole(0, 9))});
    } else if (!boxes_.empty()) {
      boxes_.erase(boxes_.begin() + dice_.whole(0, static_cast<int>(boxes_.size())));
    }
    std::fill(floor_.cells.begin(), floor_.cells.end(), Floor::kFree);
    for (const auto& [low, high] : boxes_) fill(floor_, low, high, Floor::kBlocked);
  }

  /// Plans from the committed steps on.
  void plan() {
    ++plans;
    walk_ = {};
    const Committed& c = walking_.stack.committed();
    const PlanResult result = planner_.plan(floor_, gait_base(c.stance, c.last_foot, gait_), goal_);
    if (dice_.whole(0, 50) == 0) compare(result, c);
    if (!result) return;
    ++found;
    if (result.bound < 1 || result.bound > 1.0625) ADD_FAILURE() << "bound " << result.bound;
    check(result.path);
    walk_ = place_feet(result.path, c.stance, c.last_foot, floor_, gait_);
    first_ = c.next_index;
    std::optional<hal::Foot> last = c.last_foot;
    for (const hal::Footstep& step : walk_.steps) {
      if (!within_limits(step, gait_) || step.foot == last) ADD_FAILURE() << "a step that cannot be walked";
      last = step.foot;
    }
  }

  /// What was planned before must not matter.
  void compare(const PlanResult& result, const Committed& c) {
    ++compared;
    Planner fresh({}, gait_, outline_, floor_.grid);
    const PlanResult other = fresh.plan(floor_, gait_base(c.stance, c.last_foot, gait_), goal_);
    EXPECT_EQ(result.reason, other.reason);
    EXPECT_EQ(result.path.cost_s, other.path.cost_s);
  }

  /// Nothing stands in the masks of a path's motions, but for what was too near at the start.
  void check(const Path& path) const {
    const double edge = floor_.grid.resolution, too_near = outline_.clearance() + edge;
    for (std::size_t i = 1; i < path.states.size(); ++i) {
      const PathState &a = path.states[i - 1], &b = path.states[i];
      if (a.cell == b.cell) continue;
      for (const Mask::Run& run : planner_.masks().of(motion_between(a, b)).runs) {
        for (int x = run.first; x <= run.last; ++x) {
          const Vector2i cell = a.cell + Vector2i(x, run.dy);
          if (floor_.at(cell) == Floor::kFree) continue;
          const double away = distance_to_square(outline_, path.start, floor_.grid.centre(cell), edge);
          if (away > too_near) ADD_FAILURE() << "a path meets something";
        }
      }
    }
  }

  static Motion motion_between(const PathState& a, const PathState& b) {
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{a.heading, number};
      if (m.mode() == b.mode && m.heading_after() == b.heading &&
          a.cell + cell_towards(m.direction()) == b.cell)
        return m;
    }
    ADD_FAILURE() << "two states that no motion joins";
    return {a.heading, 0};
  }

  StepPlan rest_of_walk() const {
    StepPlan plan;
    const Committed& c = walking_.stack.committed();
    plan.session = c.session;
    plan.first_index = c.next_index;
    plan.newest_frame = walking_.now;
    const std::size_t begin = walk_.steps.size() - left(),
                      count = std::min<std::size_t>(left(), StepPlan::kMost);
    std::copy_n(walk_.steps.begin() + static_cast<std::ptrdiff_t>(begin), count, plan.steps.begin());
    plan.count = static_cast<int>(count);
    plan.complete = count == left();
    return plan;
  }

  void propose() {
    if (walking_.next() < first_) plan();  // steps that were committed were none
    walking_.propose(rest_of_walk());
  }

  void propose_late() {
    StepPlan plan = rest_of_walk();
    if (plan.first_index-- == 0) return;
    ++late;
    if (walking_.propose(plan) == PlanVerdict::kTaken) ADD_FAILURE() << "a late plan was taken";
  }

  Vector2d some_place() {
    return floor_.grid.centre({dice_.whole(10, kEdge - 10), dice_.whole(10, kEdge - 10)});
  }
  Goal some_goal() {
    Goal goal{some_place(), std::nullopt, 0.1, dice_.whole(0, 4) == 0};
    if (dice_.whole(0, 2) == 0) goal.yaw = dice_.real(-3, 3);
    return goal;
  }

  Dice dice_;
  GaitLimits gait_;
  BodyOutline outline_;
  FloorMap floor_ = free_floor(kEdge, kEdge, 0.05);
  std::vector<std::pair<Vector2i, Vector2i>> boxes_;
  Planner planner_{{}, gait_, outline_, floor_.grid};
  Walking walking_;
  Goal goal_;
  Walk walk_;                ///< as planned last
  std::uint32_t first_ = 0;  ///< number of its first step
};

std::uint64_t wanted_events() {
  const char* wanted = std::getenv("HEADWAY_SOAK_EVENTS");
  return wanted == nullptr ? 300'000 : std::stoull(wanted);
}

TEST(WalkSoakSlow, BreaksNoPromiseAndTakesNoMoreMemory) {
  const std::size_t before = heap_in_use();
  const auto held = std::make_unique<std::vector<char>>(std::size_t{1} << 20);
  ASSERT_GE(heap_in_use(), before + (std::size_t{1} << 20)) << "the heap's size is not known";

  Soak soak(2006);
  const std::uint64_t events = wanted_events();
  std::size_t most[2] = {0, 0};  // in use, in the first and the second half
  while (soak.events < events && !HasFailure()) {
    soak.event();
    std::size_t& half = most[soak.events > events / 2];
    if (soak.events % 16 == 0) half = std::max(half, heap_in_use());
  }
  EXPECT_LE(most[1], most[0] + (std::size_t{64} << 10)) << "bytes of the heap that are in use";
  EXPECT_GT(soak.found, soak.plans / 2);
  EXPECT_GT(soak.steps, soak.walks);
  std::printf(
      "%llu events: %llu walks, %llu steps walked, %llu plans (%llu with a way, %llu compared with a fresh "
      "planner's), %llu late plans refused; heap at most %.3f MB in the first half, %.3f MB in the second\n",
      static_cast<unsigned long long>(soak.events), static_cast<unsigned long long>(soak.walks),
      static_cast<unsigned long long>(soak.steps), static_cast<unsigned long long>(soak.plans),
      static_cast<unsigned long long>(soak.found), static_cast<unsigned long long>(soak.compared),
      static_cast<unsigned long long>(soak.late), 1e-6 * static_cast<double>(most[0]),
      1e-6 * static_cast<double>(most[1]));
}

}  // namespace
}  // namespace headway::nav
