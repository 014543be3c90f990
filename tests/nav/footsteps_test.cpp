#include <algorithm>
#include <cmath>
#include <ostream>

#include <gtest/gtest.h>

#include "nav/body_outline.h"
#include "nav/path_legs.h"
#include "nav/walk_orders.h"
#include "nav/walking/order_steps.h"
#include "tests/nav/cell_set.h"
#include "tests/nav/random_floor.h"

namespace headway::nav {

/// In the tests' names.
inline std::ostream& operator<<(std::ostream& out, Execution execution) {
  return out << (execution == Execution::kOrders ? "Orders" : "Steps");
}

namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using hal::Foot;
using hal::Stance;

FloorMap hall() { return free_floor(160, 140, 0.05); }

double side(Foot foot) { return foot == Foot::kLeft ? 1 : -1; }

/// Where a robot may stand: parallel, or with one foot landed anywhere within the limits before the other.
struct Standing {
  Stance stance;
  std::optional<Foot> last_foot;
};

Standing some_standing(Dice& dice, const Pose2& base, const GaitLimits& gait) {
  Standing s{Stance::parallel(base, gait.feet_apart), std::nullopt};
  if (dice.whole(0, 3) == 0) return s;
  const Foot foot = dice.whole(0, 2) == 0 ? Foot::kLeft : Foot::kRight;
  const Pose2 landing{dice.real(-0.015, gait.forward_on_arc), side(foot) * dice.real(0.182, 0.235),
                      dice.real(-0.085, 0.085)};
  s.stance = s.stance.after(hal::quantised({foot, landing, 0, gait.step_duration}));
  if (dice.whole(0, 3) != 0) s.last_foot = foot;
  return s;
}

bool parallel(const Stance& s, double feet_apart) {
  const Pose2 right = s.left.inverse() * s.right;
  return std::abs(right.x) < 1e-9 && std::abs(right.y + feet_apart) < 1e-9 && std::abs(right.yaw) < 1e-9;
}

/// What must hold of any walk.
void check_walk(const Walk& walk, const Standing& from, const GaitLimits& gait) {
  ASSERT_EQ(walk.steps.size(), walk.stances.size());
  ASSERT_EQ(walk.steps.size(), walk.bases.size());
  Stance stance = from.stance;
  std::optional<Foot> last = from.last_foot;
  for (std::size_t i = 0; i < walk.steps.size(); ++i) {
    const hal::Footstep& step = walk.steps[i];
    if (last) {
      ASSERT_NE(step.foot, *last) << "step " << i;
    }
    ASSERT_TRUE(within_limits(step, gait))
        << "step " << i << ": " << step.landing.x << " " << step.landing.y << " " << step.landing.yaw;
    const hal::Footstep wired = hal::quantised(step);
    ASSERT_EQ(wired.landing.x, step.landing.x);
    ASSERT_EQ(wired.landing.y, step.landing.y);
    ASSERT_EQ(wired.landing.yaw, step.landing.yaw);
    ASSERT_EQ(wired.duration, step.duration);
    stance = stance.after(step);
    last = step.foot;
    ASSERT_EQ(stance.left.x, walk.stances[i].left.x);
    ASSERT_EQ(stance.right.y, walk.stances[i].right.y);
    ASSERT_LT((walk.bases[i].position() - gait_base(stance, last, gait).position()).norm(), 1e-9);
  }
  ASSERT_TRUE(parallel(stance, gait.feet_apart));
}

void add(CellSet& cells, const std::vector<Vector2i>& more) {
  for (const Vector2i& c : more) cells.insert(c);
}

/// All cells that the planner made sure of: the masks of the motions, and the turns at both ends.
CellSet swept(const Path& path, const FloorGrid& grid, const Masks& masks, const BodyOutline& body) {
  CellSet cells(-40, 240);
  const auto turn = [&](const Vector2d& place, double from, double to) {
    for (int i = 0; i <= 30; ++i) {
      const double yaw = from + wrap_angle(to - from) * i / 30;
      add(cells, body_cells(grid, body, {place.x(), place.y(), yaw}));
    }
  };
  const bool moves = path.states.size() > 1;
  const double first = moves ? heading_angle(path.states.front().heading) : path.start.yaw;
  turn(path.start.position(), path.start.yaw, first);
  for (std::size_t i = 1; i < path.states.size(); ++i) {
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{path.states[i - 1].heading, number};
      const bool it = m.mode() == path.states[i - 1].mode && m.heading_after() == path.states[i].heading &&
                      path.states[i - 1].cell + cell_towards(m.direction()) == path.states[i].cell;
      if (!it) continue;
      for (const Mask::Run& run : masks.of(m).runs) {
        for (int x = run.first; x <= run.last; ++x) {
          cells.insert({path.states[i - 1].cell.x() + x, path.states[i - 1].cell.y() + run.dy});
        }
      }
    }
  }
  const double last = moves ? heading_angle(path.states.back().heading) : path.start.yaw;
  turn(path.end, last, path.end_yaw.value_or(last));
  return cells;
}

/// How much of the clearance is left when the body follows the feet.
void check_body(const Walk& walk, const Path& path, const FloorGrid& grid, const Masks& masks) {
  BodyOutline three_centimetres_less;
  three_centimetres_less.safety_margin -= 0.03;
  const CellSet sure = swept(path, grid, masks, BodyOutline{});
  Pose2 before = path.start;
  for (std::size_t i = 0; i < walk.bases.size(); ++i) {
    const Pose2& after = walk.bases[i];
    for (const double t : {0.25, 0.5, 0.75, 1.0}) {
      const Vector2d p = before.position() + t * (after.position() - before.position());
      const Pose2 between{p.x(), p.y(), before.yaw + t * wrap_angle(after.yaw - before.yaw)};
      for (const Vector2i& c : body_cells(grid, three_centimetres_less, between)) {
        ASSERT_TRUE(sure.contains(c)) << "step " << i << " of " << walk.bases.size();
      }
    }
    before = after;
  }
}

double last_leg(const Path& path) {
  int cells = 0;
  for (std::size_t i = path.states.size(); i-- > 1; ++cells) {
    if (path.states[i].heading != path.states[i - 1].heading || path.states[i].mode == Mode::kSideway) break;
  }
  return 0.05 * cells;
}

/// The steps of a walk in orders are those that its orders mean, and take the base past the end of every leg.
void check_orders(const Walk& walk, const Path& path, const Standing& from, const FloorGrid& grid,
                  const GaitLimits& gait) {
  ASSERT_EQ(walk.orders.size(), walk.steps.size());
  Stance stance = from.stance;
  std::optional<Foot> last = from.last_foot;
  for (std::size_t i = 0; i < walk.steps.size();) {
    ASSERT_EQ(walk.orders[i].place, 0) << "step " << i;
    const auto steps = steps_of(walk.orders[i].order, stance, last, gait);
    ASSERT_TRUE(steps);
    for (std::size_t place = 0; place < steps->count; ++place, ++i) {
      const hal::Footstep &meant = steps->steps[place], &planned = walk.steps[i];
      ASSERT_EQ(walk.orders[i].place, place);
      ASSERT_EQ(meant.foot, planned.foot);
      ASSERT_EQ(meant.landing.x, planned.landing.x);
      ASSERT_EQ(meant.landing.y, planned.landing.y);
      ASSERT_EQ(meant.landing.yaw, planned.landing.yaw);
      stance = stance.after(meant);
      last = meant.foot;
    }
  }
  for (const Leg& leg : legs_of(path, grid)) {
    if ((leg.to - leg.from).norm() < 0.01) continue;
    const bool passed = std::any_of(walk.bases.begin(), walk.bases.end(), [&](const Pose2& base) {
      return (base.position() - leg.to).norm() < 0.006 && std::abs(wrap_angle(base.yaw - leg.yaw)) < 0.003;
    });
    ASSERT_TRUE(passed) << "the end of a leg at " << leg.to.transpose();
  }
}

class WalkAlong : public testing::TestWithParam<Execution> {};
INSTANTIATE_TEST_SUITE_P(Both, WalkAlong, testing::Values(Execution::kSteps, Execution::kOrders),
                         testing::PrintToStringParamName());

TEST_P(WalkAlong, AnyPathKeepsTheLimitsAndEndsParallelAtTheGoal) {
  Dice dice(7);
  const GaitLimits gait;
  Planner planner({}, gait, {}, hall().grid);
  int walked = 0;
  for (int run = 0; run < 150; ++run) {
    FloorMap map = run % 2 == 0 ? hall() : random_floor(160, 140, 0.05, dice);
    const Pose2 place{dice.real(0, 6), dice.real(1, 6.5), dice.real(-4, 4)};
    const Standing standing = some_standing(dice, place, gait);
    const Pose2 start = gait_base(standing.stance, standing.last_foot, gait);
    Goal goal{{dice.real(0, 6), dice.real(1, 6.5)}, std::nullopt, 0.1};
    if (dice.whole(0, 3) == 0)
      goal.position = place.position() + Vector2d(dice.real(-.5, .5), dice.real(-.5, .5));
    if (dice.whole(0, 2) == 0) goal.yaw = dice.real(-4, 4);
    const auto result = planner.plan(map, start, goal);
    if (!result) continue;
    ++walked;
    const Path& path = result.path;
    const Walk walk = walk_along(GetParam(), path, standing.stance, standing.last_foot, map, gait);
    check_walk(walk, standing, gait);
    if (HasFatalFailure()) FAIL() << "run " << run;
    if (GetParam() == Execution::kOrders) check_orders(walk, path, standing, map.grid, gait);
    if (HasFatalFailure()) FAIL() << "run " << run;
    check_body(walk, path, map.grid, planner.masks());
    if (HasFatalFailure()) FAIL() << "run " << run;
    const Stance end = walk.stances.empty() ? standing.stance : walk.stances.back();
    const double off = (end.base().position() - path.end).norm();
    EXPECT_LT(off, path.states.size() == 1 ? 0.075 : last_leg(path) > 0.4 ? 0.01 : 0.04) << "run " << run;
    if (path.end_yaw) {
      EXPECT_NEAR(wrap_angle(end.base().yaw - *path.end_yaw), 0, 0.002) << "run " << run;
    }
    // No needless steps: what the planner counted, and a few for closing and for corners.
    const double corners = path.cost.turning / 7.2 + path.cost.mode_changes / 1.6;
    const double counted = path.cost.walking + path.cost.turning + path.cost.mode_changes;
    EXPECT_LE(0.8 * static_cast<double>(walk.steps.size()), 1.03 * counted + 0.8 * (5 + 2 * corners))
        << "run " << run;
  }
  EXPECT_GT(walked, 80);
}

Path straight(const FloorGrid& grid, const Pose2& start, const Vector2d& end, int heading) {
  Path path;
  path.start = start;
  path.end = end;
  Vector2i cell = grid.cell(start.position());
  path.states.push_back({cell, heading, Mode::kForward});
  while (cell != grid.cell(end)) {
    cell += cell_towards(heading);
    path.states.push_back({cell, heading, Mode::kForward});
  }
  return path;
}

TEST(Footsteps, TakeTheFewestStepsStraightOn) {
  const FloorGrid grid = hall().grid;
  const GaitLimits gait;
  const Vector2d from = grid.centre({40, 40}), to = grid.centre({80, 40});
  const Pose2 start{from.x(), from.y(), 0};
  const Walk walk =
      place_feet(straight(grid, start, to, 0), Stance::parallel(start, gait.feet_apart), {}, hall(), gait);
  EXPECT_EQ(walk.steps.size(), 11u);  // 2 m in ten, and one to close
  EXPECT_NEAR(walk.stances.back().base().x, to.x(), 1e-3);
}

TEST(Footsteps, MakeAStepAnArcWhenTheWireRoundsItUpToOne) {
  const FloorGrid grid = hall().grid;
  const GaitLimits gait;
  const Vector2d from = grid.centre({40, 40}), to = grid.centre({80, 40});
  for (double yaw = gait.arc_begins - 0.002; yaw < gait.arc_begins + 0.002; yaw += 1e-4) {
    const Pose2 start{from.x(), from.y(), yaw};
    const Standing standing{Stance::parallel(start, gait.feet_apart), std::nullopt};
    check_walk(place_feet(straight(grid, start, to, 0), standing.stance, {}, hall(), gait), standing, gait);
  }
}

TEST(Footsteps, GoOnWithTheOtherFootAsIfNothingHadHappened) {
  const FloorGrid grid = hall().grid;
  const GaitLimits gait;
  const Vector2d from = grid.centre({40, 40}), to = grid.centre({100, 40});
  const Pose2 start{from.x(), from.y(), 0};
  const Walk whole =
      place_feet(straight(grid, start, to, 0), Stance::parallel(start, gait.feet_apart), {}, hall(), gait);
  for (std::size_t done = 1; done < whole.steps.size(); ++done) {
    const Stance stance = whole.stances[done - 1];
    const Foot last = whole.steps[done - 1].foot;
    const Path rest = straight(grid, gait_base(stance, last, gait), to, 0);
    const Walk again = place_feet(rest, stance, last, hall(), gait);
    EXPECT_EQ(again.steps.size(), whole.steps.size() - done) << "after " << done;
  }
}

TEST(Footsteps, TurnOnTheSpotByFiveDegreesAStep) {
  const FloorGrid grid = hall().grid;
  const GaitLimits gait;
  const Vector2d here = grid.centre({80, 70});
  for (const double turn : {-3.0, -0.7, 0.5, 1.5, 3.1}) {
    Path path;
    path.start = {here.x(), here.y(), 0.2};
    path.states = {{{80, 70}, 0, Mode::kForward}};
    path.end = here;
    path.end_yaw = 0.2 + turn;
    const Walk walk = place_feet(path, Stance::parallel(path.start, gait.feet_apart), {}, hall(), gait);
    EXPECT_LE(walk.steps.size(), static_cast<std::size_t>(std::ceil(std::abs(turn) / 0.086)) + 2) << turn;
    EXPECT_NEAR(wrap_angle(walk.stances.back().base().yaw - 0.2 - turn), 0, 0.002);
    EXPECT_LT((walk.stances.back().base().position() - here).norm(), 0.004);
    for (const Pose2& b : walk.bases) EXPECT_LT((b.position() - here).norm(), 0.004);
  }
}

TEST(Footsteps, BeginSidewaysWithTheOuterFoot) {
  const FloorGrid grid = hall().grid;
  const GaitLimits gait;
  for (const int way : {-1, 1}) {
    Path path;
    path.start = {grid.centre({80, 70}).x(), grid.centre({80, 70}).y(), 0};
    for (int i = 0; i <= 6; ++i) path.states.push_back({{80, 70 + way * i}, 0, Mode::kSideway});
    path.end = grid.centre({80, 70 + way * 6});
    const Walk walk = place_feet(path, Stance::parallel(path.start, gait.feet_apart), {}, hall(), gait);
    EXPECT_EQ(walk.steps.size(), 12u);  // two for each 5 cm
    EXPECT_EQ(walk.steps.front().foot, way > 0 ? Foot::kLeft : Foot::kRight);
    EXPECT_LT((walk.stances.back().base().position() - path.end).norm(), 1e-3);
  }
}

GaitLimits stepping_over(double height = 0.06) {
  GaitLimits gait;
  gait.over.height = height;
  return gait;
}

/// Low ground from wall to wall, `deep` cells across the way of one who faces `heading` and starts in `from`:
/// its first row lies `ahead` cells on.
FloorMap hall_with_bar(const Vector2i& from, int heading, int ahead, int deep) {
  FloorMap map = hall();
  const Vector2i on = cell_towards(heading);
  for (int y = 0; y < map.grid.height; ++y)
    for (int x = 0; x < map.grid.width; ++x) {
      const int at = (Vector2i(x, y) - from).dot(on) - ahead * on.squaredNorm();
      if (at >= 0 && at < deep) map.cells[map.grid.index({x, y})] = Floor::kLow;
    }
  return map;
}

bool treads_on_low(const FloorMap& map, const GaitLimits& gait, const Pose2& sole) {
  const auto cells = sole_cells(map.grid, gait, sole);
  return std::any_of(cells.begin(), cells.end(),
                     [&](const Vector2i& cell) { return map.at(cell) == Floor::kLow; });
}

/// Whether a sole goes over low ground between two places.
bool goes_over_low(const FloorMap& map, const GaitLimits& gait, const Pose2& from, const Pose2& to) {
  for (int i = 0; i <= 40; ++i) {
    const Vector2d p = from.position() + i / 40.0 * (to.position() - from.position());
    if (treads_on_low(map, gait, {p.x(), p.y(), to.yaw})) return true;
  }
  return false;
}

bool same(const hal::Footstep& a, const hal::Footstep& b) {
  return a.foot == b.foot && a.landing.position() == b.landing.position() && a.landing.yaw == b.landing.yaw &&
         a.dz == b.dz && a.duration == b.duration && a.clear == b.clear;
}

void expect_same(const Walk& a, const Walk& b) {
  ASSERT_EQ(a.steps.size(), b.steps.size());
  for (std::size_t i = 0; i < a.steps.size(); ++i) ASSERT_TRUE(same(a.steps[i], b.steps[i])) << "step " << i;
}

/// Along the line of cells to the goal's, from that nearest to the start.
Path straight_to(const FloorGrid& grid, const Pose2& start, const Vector2d& goal, int heading) {
  const Vector2d step = cell_towards(heading).cast<double>() * grid.resolution;
  const double left = (goal - start.position()).dot(step) / step.squaredNorm();
  Path path;
  path.start = start;
  path.end = goal;
  for (int i = static_cast<int>(std::lround(left)); i >= 0; --i)
    path.states.push_back({grid.cell(goal) - i * cell_towards(heading), heading, Mode::kForward});
  if (path.states.empty()) path.states = {{grid.cell(goal), heading, Mode::kForward}};
  return path;
}

/// Walks a straight way as a mission does: plans its steps, makes the first of them, and plans again. After
/// each the map turns out to lie a little otherwise, as `corrected` has it of a stance.
template <class Correction>
void check_walk_over(const FloorMap& map, const Pose2& start, const Vector2d& goal, int heading,
                     const GaitLimits& gait, int& passed, const Correction& corrected) {
  Standing standing{Stance::parallel(start, gait.feet_apart), std::nullopt};
  const double clear = hal::quantised({{}, {}, 0, {}, gait.over.height}).clear;
  bool was_corrected = false;
  int made = 0;
  for (; made < 100; ++made) {
    const Pose2 base = gait_base(standing.stance, standing.last_foot, gait);
    const Walk walk = place_feet(straight_to(map.grid, base, goal, heading), standing.stance,
                                 standing.last_foot, map, gait);
    ASSERT_FALSE(walk.treads_on_low) << "after " << made;
    check_walk(walk, standing, gait);
    if (walk.steps.empty()) break;
    const hal::Footstep& step = walk.steps.front();
    const Stance after = standing.stance.after(step);
    const Pose2 &from = standing.stance.at(step.foot), &to = after.at(step.foot);
    ASSERT_FALSE(treads_on_low(map, gait, to)) << "step " << made;
    const bool passes = goes_over_low(map, gait, from, to);
    // Set right, a foot may stand within its margin, and then goes high for nothing.
    const bool high = passes || (was_corrected && step.clear > 0);
    ASSERT_EQ(step.clear, high ? clear : 0) << "step " << made;
    ASSERT_EQ(step.duration, high ? gait.over.duration : gait.step_duration) << "step " << made;
    passed += passes;
    standing = {corrected(after), step.foot};
    was_corrected |= standing.stance.left.yaw != after.left.yaw;
  }
  ASSERT_LT(made, 100);
  ASSERT_LT((standing.stance.base().position() - goal).norm(), 0.015);
  ASSERT_TRUE(parallel(standing.stance, gait.feet_apart));
}

/// A bar, and a way over it that ends well beyond, or as near behind it as a sole may be.
struct WayOver {
  int heading, deep;
  FloorMap map;
  Pose2 start;
  Vector2d goal;
};

WayOver some_way_over(Dice& dice, const GaitLimits& gait) {
  const int heading = dice.whole(0, kHeadings), ahead = dice.whole(6, 50), deep = dice.whole(1, 3);
  const Vector2i from(80, 70);
  const FloorMap map = hall_with_bar(from, heading, ahead, deep);
  const Vector2d step = cell_towards(heading).cast<double>(), on = step.normalized();
  const Vector2d begin = map.grid.centre(from) + dice.real(-0.02, 0.02) * on;
  const double cell = map.grid.resolution;
  const double last = cell * (ahead * step.norm() + (deep - 1) / step.norm());  // row of the bar, ahead
  const double near = gait.sole_length / 2 + gait.over.margin + cell / 2 * on.cwiseAbs().sum();
  const double beyond = near + (dice.whole(0, 2) == 0 ? dice.real(-0.003, 0.003) : dice.real(0, 0.6));
  return {heading, deep, map, Pose2{begin.x(), begin.y(), heading_angle(heading)},
          map.grid.centre(from) + (last + beyond) * on};
}

TEST(Footsteps, GoOverWhatIsLowAndNeverOntoIt) {
  Dice dice(31);
  const GaitLimits gait = stepping_over();
  int passed = 0;
  for (int run = 0; run < 300; ++run) {
    const WayOver way = some_way_over(dice, gait);
    check_walk_over(way.map, way.start, way.goal, way.heading, gait, passed, [](Stance s) { return s; });
    if (HasFatalFailure()) FAIL() << "run " << run << ": heading " << way.heading << ", deep " << way.deep;
  }
  EXPECT_GE(passed, 400) << "both feet, wherever a bar lies inside of the hall";
}

TEST(Footsteps, GoOverWhatIsLowWhileTheMapIsSetRight) {
  Dice dice(33);
  const GaitLimits gait = stepping_over();
  int passed = 0;
  for (int run = 0; run < 300; ++run) {
    const WayOver way = some_way_over(dice, gait);
    const int times = dice.whole(1, 4);
    int left = times;
    const auto corrected = [&](const Stance& s) {
      if (left == 0 || dice.whole(0, 3) != 0) return s;
      --left;
      const Pose2 base = s.base();
      const Pose2 moved{base.x + dice.real(-0.003, 0.003), base.y + dice.real(-0.003, 0.003),
                        base.yaw + dice.real(-0.05, 0.05)};
      const Pose2 by = moved * base.inverse();
      return Stance{by * s.left, by * s.right};
    };
    check_walk_over(way.map, way.start, way.goal, way.heading, gait, passed, corrected);
    if (HasFatalFailure()) FAIL() << "run " << run << ": heading " << way.heading << ", deep " << way.deep;
  }
  EXPECT_GE(passed, 400);
}

TEST(Footsteps, SayThatNoneGoOverWhatIsTooDeep) {
  const GaitLimits gait = stepping_over();
  const Vector2i from(80, 70);
  for (const int heading : {0, 2, 4, 6}) {
    for (int ahead = 7; ahead < 20; ++ahead) {
      for (const int deep : {4, 6}) {
        const FloorMap map = hall_with_bar(from, heading, ahead, deep);
        const Vector2d begin = map.grid.centre(from),
                       goal = map.grid.centre(from + (ahead + deep + 8) * cell_towards(heading));
        const Pose2 start{begin.x(), begin.y(), heading_angle(heading)};
        const Stance stance = Stance::parallel(start, gait.feet_apart);
        EXPECT_TRUE(place_feet(straight(map.grid, start, goal, heading), stance, {}, map, gait).treads_on_low)
            << heading << " " << ahead << " " << deep;
      }
    }
  }
}

TEST(Footsteps, AreTheSameOnFloorWithNothingLowWhetherOrNotTheyMayGoOverIt) {
  Dice dice(32);
  const GaitLimits plain, over = stepping_over();
  Planner planner({}, plain, {}, hall().grid);
  int walked = 0;
  for (int run = 0; run < 60; ++run) {
    const FloorMap map = random_floor(160, 140, 0.05, dice);
    const Standing standing =
        some_standing(dice, {dice.real(0, 6), dice.real(1, 6.5), dice.real(-4, 4)}, plain);
    const Pose2 start = gait_base(standing.stance, standing.last_foot, plain);
    const auto result = planner.plan(map, start, {{dice.real(0, 6), dice.real(1, 6.5)}, std::nullopt, 0.1});
    if (!result) continue;
    ++walked;
    expect_same(place_feet(result.path, standing.stance, standing.last_foot, map, plain),
                place_feet(result.path, standing.stance, standing.last_foot, map, over));
  }
  EXPECT_GT(walked, 20);
}

}  // namespace
}  // namespace headway::nav
