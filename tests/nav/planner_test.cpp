#include "nav/planner.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numbers>
#include <queue>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/nav/random_floor.h"
#include "tests/nav/textbook_search.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

/// A body small enough for small maps.
constexpr BodyOutline kSmallBody{0.10, 0.16, 0.02, 0.03};

/// Whether nothing stands where the small body may touch while it turns.
bool open_ground(const FloorMap& map, const Vector2d& place) {
  for (int y = -1; y <= map.grid.height; ++y) {
    for (int x = -1; x <= map.grid.width; ++x) {
      if (map.grid.contains({x, y}) && map.at({x, y}) == Floor::kFree) continue;
      const Vector2d away = (map.grid.centre({x, y}) - place).cwiseAbs();
      if (away.norm() < kSmallBody.reach() + map.grid.resolution) return false;
    }
  }
  return true;
}

Vector2d some_place(const FloorMap& map, Dice& dice) {
  return map.grid.centre({dice.whole(0, map.grid.width), dice.whole(0, map.grid.height)}) +
         Vector2d(dice.real(-0.49, 0.49), dice.real(-0.49, 0.49)) * map.grid.resolution;
}

std::optional<Vector2d> some_open_place(const FloorMap& map, Dice& dice) {
  for (int trial = 0; trial < 100; ++trial) {
    const Vector2d place = some_place(map, dice);
    if (open_ground(map, place)) return place;
  }
  return std::nullopt;
}

/// Checks a path state by state: each is one motion or mode change from the last, meets nothing and costs
/// what it says.
void walk_again(const Path& path, const FloorMap& map, const PlannerConfig& config, const Masks& masks) {
  const TextbookSearch textbook(map, config, {}, masks);
  ASSERT_EQ(path.states.size(), path.cost_so_far_s.size());
  ASSERT_EQ(path.states.front().cell, map.grid.cell(path.start.position()));
  ASSERT_EQ(path.states.back().cell, map.grid.cell(path.end));
  for (std::size_t i = 1; i < path.states.size(); ++i) {
    const PathState &a = path.states[i - 1], &b = path.states[i];
    const double cost = path.cost_so_far_s[i] - path.cost_so_far_s[i - 1];
    if (a.cell == b.cell) {
      ASSERT_EQ(a.heading, b.heading);
      ASSERT_NE(a.mode, b.mode);
      ASSERT_NEAR(cost, textbook.mode_change() * textbook.tick(), 1e-9);
      continue;
    }
    ASSERT_EQ(a.mode, b.mode);
    int matching = 0;
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{a.heading, number};
      if (m.mode() != a.mode || m.heading_after() != b.heading) continue;
      if (a.cell + cell_towards(m.direction()) != b.cell) continue;
      ++matching;
      ASSERT_FALSE(textbook.blocked(a.cell, m)) << "state " << i;
      ASSERT_NEAR(cost, textbook.motion(a.cell, m) * textbook.tick(), 1e-9);
    }
    ASSERT_EQ(matching, 1);
  }
}

TEST(Planner, FindsTheCheapestPathOrNoneWhereThereIsNone) {
  int found = 0, none = 0;
  Dice dice(11);
  for (int run = 0; run < 120; ++run) {
    const FloorMap map = random_floor(dice.whole(12, 44), dice.whole(12, 44), 0.08, dice);
    PlannerConfig config;
    config.unseen = std::array{UnseenFloor::kBlocked, UnseenFloor::kCostly,
                               UnseenFloor::kFree}[static_cast<std::size_t>(dice.whole(0, 3))];
    config.near_price = dice.whole(0, 3);
    config.near_range = dice.real(0, 0.7);
    config.turn_price = dice.real(0, 1.5);
    config.mode_change = dice.real(0, 3);
    config.start_is_free = false;
    const auto place = some_open_place(map, dice);
    if (!place) continue;
    const Pose2 start{place->x(), place->y(), dice.real(-4, 4)};
    Goal goal{some_place(map, dice), std::nullopt, 0};
    if (open_ground(map, goal.position) && dice.whole(0, 2) == 0) goal.yaw = dice.real(-4, 4);
    if (map.grid.cell(*place) == map.grid.cell(goal.position)) continue;

    Planner planner(config, {}, kSmallBody, map.grid);
    TextbookSearch textbook(map, config, {}, planner.masks());
    const PlanResult result = planner.plan(map, start, goal);
    const std::uint32_t cheapest = textbook.cost(start, goal);
    ASSERT_EQ(static_cast<bool>(result), cheapest != TextbookSearch::kNoWay) << "run " << run;
    ++(result ? found : none);
    if (!result) continue;
    ASSERT_NEAR(result.path.cost_s, cheapest * textbook.tick(), 1e-9) << "run " << run;
    ASSERT_NEAR(result.path.cost.total(), result.path.cost_s, 1e-9);
    walk_again(result.path, map, config, planner.masks());
  }
  EXPECT_GT(found, 40);
  EXPECT_GT(none, 10);
}

TEST(Planner, PathsMeetNoBlockedCellWhenWalkedAgain) {
  Dice dice(5);
  int walked = 0;
  for (int run = 0; run < 30; ++run) {
    const FloorMap map = random_floor(60, 50, 0.05, dice);
    PlannerConfig config;
    config.start_is_free = false;
    Planner planner(config, {}, kSmallBody, map.grid);
    const auto place = some_open_place(map, dice), goal = some_open_place(map, dice);
    if (!place || !goal) continue;
    const auto result = planner.plan(map, {place->x(), place->y(), dice.real(-4, 4)}, {*goal, {}, 0.1});
    if (!result || result.path.states.size() < 2) continue;
    walk_again(result.path, map, config, planner.masks());
    if (HasFatalFailure()) return;
    ++walked;
  }
  EXPECT_GT(walked, 10);
}

TEST(Planner, IsTheSameWhateverItPlannedBefore) {
  Dice dice(3);
  const FloorMap map = random_floor(60, 50, 0.05, dice), other = random_floor(50, 70, 0.05, dice);
  const Pose2 start{0, 1, 0.3};
  const Goal goal{{1.5, 2.0}, 1.0, 0.3};
  Planner fresh({}, {}, kSmallBody, map.grid), used({}, {}, kSmallBody, map.grid);
  used.plan(other, {1, 1, 0}, {{0, 2}, {}, 0.2});
  used.plan(map, {1, 1.2, 0}, {{0, 2}, {}, 0.2});
  const auto a = fresh.plan(map, start, goal), b = used.plan(map, start, goal);
  ASSERT_TRUE(a) << describe(a.reason);
  EXPECT_EQ(a.path.states, b.path.states);
  EXPECT_EQ(a.path.cost_so_far_s, b.path.cost_so_far_s);
}

/// Obstacles that come onto the path and go again: what was made of the last map does for the next one.
TEST(Planner, CostsTheSameOnAPatchedMapAsWhenPlannedAnew) {
  Dice dice(12);
  int compared = 0, dearer = 0, cheaper = 0;
  for (int run = 0; run < 30; ++run) {
    FloorMap map = random_floor(dice.whole(30, 70), dice.whole(30, 70), 0.08, dice);
    const auto from = some_open_place(map, dice), to = some_open_place(map, dice);
    if (!from || !to) continue;
    const Pose2 start{from->x(), from->y(), dice.real(-4, 4)};
    const Goal goal{*to, std::nullopt, 0};
    PlannerConfig config;
    config.start_is_free = run % 2 == 0;
    Planner used(config, {}, kSmallBody, map.grid);
    PlanResult last = used.plan(map, start, goal);
    for (int change = 0; change < 6; ++change) {
      const std::vector<PathState>& states = last.path.states;
      const Vector2i on_path = states.empty() ? map.grid.cell(*to) : states[states.size() / 2].cell;
      const Vector2i low = on_path - Vector2i(dice.whole(0, 4), dice.whole(0, 4));
      fill(map, low, low + Vector2i(dice.whole(1, 5), dice.whole(1, 5)),
           change % 2 == 0 ? Floor::kBlocked : Floor::kFree);
      const PlanResult warm = used.plan(map, start, goal);
      const PlanResult cold = Planner(config, {}, kSmallBody, map.grid).plan(map, start, goal);
      ASSERT_EQ(warm.reason, cold.reason) << "run " << run << " change " << change;
      ASSERT_EQ(warm.path.states, cold.path.states) << "run " << run << " change " << change;
      ASSERT_EQ(warm.path.cost_s, cold.path.cost_s);
      if (warm && last) {
        ++compared;
        dearer += warm.path.cost_s > last.path.cost_s;
        cheaper += warm.path.cost_s < last.path.cost_s;
      }
      last = warm;
    }
  }
  EXPECT_GT(compared, 30);
  EXPECT_GT(dearer, 5);
  EXPECT_GT(cheaper, 5);
}

/// HRP-2 in a room of 8 x 7 m: outer cells blocked.
FloorMap room() {
  FloorMap map = free_floor(160, 140, 0.05);
  fill(map, {0, 0}, {159, 0}, Floor::kBlocked);
  fill(map, {0, 139}, {159, 139}, Floor::kBlocked);
  fill(map, {0, 0}, {0, 139}, Floor::kBlocked);
  fill(map, {159, 0}, {159, 139}, Floor::kBlocked);
  return map;
}

Vector2d at(const FloorMap& map, double x, double y) { return map.grid.origin + Vector2d(x, y); }

TEST(Planner, WalksStraightOnWhereItCan) {
  const FloorMap map = room();
  Planner planner({}, {}, {}, map.grid);
  const Vector2d from = at(map, 2.025, 3.525), to = at(map, 5.025, 3.525);
  const auto result = planner.plan(map, {from.x(), from.y(), 0}, {to, {}, 0.1});
  ASSERT_TRUE(result);
  EXPECT_EQ(result.path.states.size(), 61u);
  EXPECT_NEAR(result.path.cost_s, 12.0, 1e-9);  // fifteen steps of 0.2 m
  EXPECT_EQ(result.path.cost.turning, 0);
}

TEST(Planner, SidestepsThroughAGapTooNarrowForItsArms) {
  // A slot 0.7 m wide: the body passes it along its depth (0.40 m + 2 * 0.08 m), not along its width (0.62 m
  // + 0.16 m).
  FloorMap map = room();
  fill(map, {80, 1}, {82, 62}, Floor::kBlocked);
  fill(map, {80, 77}, {82, 138}, Floor::kBlocked);
  Planner planner({}, {}, {}, map.grid);
  const Vector2d from = at(map, 2.5, 3.5), to = at(map, 5.5, 3.5);
  const auto result = planner.plan(map, {from.x(), from.y(), 0}, {to, {}, 0.1});
  ASSERT_TRUE(result);
  for (const PathState& s : result.path.states) {
    if (s.cell.x() >= 78 && s.cell.x() <= 84) {
      EXPECT_EQ(s.mode, Mode::kSideway);
      EXPECT_EQ(s.heading % 4, 2);
    }
  }
  EXPECT_GT(result.path.cost.mode_changes, 0);
}

TEST(Planner, TellsWhyThereIsNoPath) {
  FloorMap map = room();
  Planner planner({}, {}, {}, map.grid);
  const Vector2d from = at(map, 2.025, 3.475);
  const Pose2 start{from.x(), from.y(), 0};
  const auto reason = [&](const Vector2d& to) { return planner.plan(map, start, {to, {}, 0.1}).reason; };
  EXPECT_EQ(reason(at(map, 5, 3.5)), NoPath::kNone);
  EXPECT_EQ(reason(at(map, 9, 3.5)), NoPath::kGoalOutside);
  EXPECT_EQ(reason(at(map, 0.2, 3.5)), NoPath::kGoalBlocked);
  EXPECT_EQ(planner.plan(map, {-5, -5, 0}, {at(map, 5, 3.5), {}, 0.1}).reason, NoPath::kStartBlocked);
  fill(map, {80, 0}, {80, 139}, Floor::kBlocked);
  const auto enclosed = planner.plan(map, start, {at(map, 5, 3.5), {}, 0.1});
  EXPECT_EQ(enclosed.reason, NoPath::kEnclosed);
  ASSERT_TRUE(enclosed.nearest);
  // As near to the wall as the body comes sideways, at the goal's height.
  EXPECT_NEAR(enclosed.nearest->x(), at(map, 4.0 - 0.28, 0).x(), 0.08);
  EXPECT_NEAR(enclosed.nearest->y(), at(map, 0, 3.5).y(), 0.05);
  fill(map, {20, 50}, {60, 90}, Floor::kBlocked);
  fill(map, {36, 63}, {44, 75}, Floor::kFree);  // 0.45 x 0.65 m around a body of 0.40 x 0.62 m
  EXPECT_EQ(planner.plan(map, start, {at(map, 5, 3.5), {}, 0.1}).reason, NoPath::kStartBlocked);
}

/// Sixteen bits hold no more than 65 cells of a thousand ticks.
TEST(Planner, CountsInCoarserTicksWhereAWalkIsTooLongForFineOnes) {
  const FloorMap map = room();
  const Vector2d from = at(map, 1.525, 3.525);
  const Pose2 start{from.x(), from.y(), 0};
  const Goal goal{at(map, 6.525, 3.525), 0.0, 0.1};
  PlannerConfig config;
  Planner usual(config, {}, {}, map.grid);
  config.ticks_per_cell = 1000;
  Planner fine(config, {}, {}, map.grid);
  const PlanResult result = fine.plan(map, start, goal), expected = usual.plan(map, start, goal);
  ASSERT_TRUE(result) << describe(result.reason);
  ASSERT_GT(expected.path.cost_s, 65535 * fine.tick());
  EXPECT_NEAR(result.path.cost_s, expected.path.cost_s, 0.01 * expected.path.cost_s);
  EXPECT_EQ(result.path.states, expected.path.states);
}

TEST(Planner, SaysWhenAWalkIsLongerThanAnyTicksCount) {
  FloorMap map = free_floor(720, 30, 0.05);
  std::ranges::fill(map.cells, Floor::kUnseen);
  const PlannerConfig config{.unseen_price = 100, .ticks_per_cell = 2};  // with 1, 65535 / 101 is 648 cells
  Planner planner(config, {}, {}, map.grid);
  const Vector2d from = at(map, 1.025, 0.725);
  const Pose2 start{from.x(), from.y(), 0};
  EXPECT_TRUE(planner.plan(map, start, {at(map, 31.025, 0.725), {}, 0.1}));
  EXPECT_EQ(planner.plan(map, start, {at(map, 35.025, 0.725), {}, 0.1}).reason, NoPath::kTooFar);
}

TEST(Planner, TakesTheNearestPlaceWithinToleranceWhenTheGoalIsTooTight) {
  const FloorMap map = room();
  Planner planner({}, {}, {}, map.grid);
  const Vector2d from = at(map, 4, 3.5), wish = at(map, 0.30, 3.5);
  const auto result = planner.plan(map, {from.x(), from.y(), 0}, {wish, {}, 0.15});
  ASSERT_TRUE(result) << describe(result.reason);
  EXPECT_GT((result.path.end - wish).norm(), 0.01);
  EXPECT_LE((result.path.end - wish).norm(), 0.15);
}

/// The least distance from a goal to the centre of a cell to which the textbook finds a way.
double nearest_by_trial(const FloorMap& map, const PlannerConfig& config, const Masks& masks,
                        const Pose2& start, const Vector2d& goal) {
  TextbookSearch textbook(map, config, {}, masks);
  std::vector<Vector2d> places;
  for (int y = 0; y < map.grid.height; ++y)
    for (int x = 0; x < map.grid.width; ++x) places.push_back(map.grid.centre({x, y}));
  const auto distance = [&](const Vector2d& place) { return (place - goal).norm(); };
  std::sort(places.begin(), places.end(),
            [&](const Vector2d& a, const Vector2d& b) { return distance(a) < distance(b); });
  const auto first = std::find_if(places.begin(), places.end(), [&](const Vector2d& place) {
    return textbook.cost(start, {place, std::nullopt, 0}) != TextbookSearch::kNoWay;
  });
  return first == places.end() ? std::numeric_limits<double>::infinity() : distance(*first);
}

TEST(Planner, GoesToTheReachablePlaceNearestToTheGoalWhenThatWillDo) {
  Dice dice(31);
  int near = 0, there = 0;
  for (int run = 0; run < 40; ++run) {
    const FloorMap map = random_floor(40, 30, 0.05, dice);
    PlannerConfig config;
    config.start_is_free = false;
    const auto place = some_open_place(map, dice);
    if (!place) continue;
    const Pose2 start{place->x(), place->y(), dice.real(-4, 4)};
    Goal goal{some_place(map, dice), std::nullopt, 0, true};
    if (run % 4 == 0) goal.position += Vector2d(0, 3);  // outside of the map
    Planner planner(config, {}, kSmallBody, map.grid);
    const PlanResult result = planner.plan(map, start, goal);
    if (!result) continue;
    goal.near = false;
    const PlanResult strict = planner.plan(map, start, goal);
    ASSERT_EQ(result.short_of_goal, strict.reason) << "run " << run;
    ++(strict ? there : near);
    const double least = strict ? (strict.path.end - goal.position).norm()
                                : nearest_by_trial(map, config, planner.masks(), start, goal.position);
    ASSERT_NEAR((result.path.end - goal.position).norm(), least, 1e-9) << "run " << run;
    if (result.path.states.size() > 1) walk_again(result.path, map, config, planner.masks());
  }
  EXPECT_GT(near, 8);
  EXPECT_GT(there, 4);
}

TEST(Planner, ComesNearFacingAsWished) {
  FloorMap map = room();
  fill(map, {80, 0}, {80, 139}, Floor::kBlocked);
  Planner planner({}, {}, {}, map.grid);
  const Vector2d from = at(map, 2.025, 3.475), to = at(map, 5, 3.5);
  for (const double yaw : {0.0, 1.5708, -2.4}) {
    const PlanResult result = planner.plan(map, {from.x(), from.y(), 0}, {to, yaw, 0.1, true});
    ASSERT_TRUE(result) << describe(result.reason);
    EXPECT_EQ(result.short_of_goal, NoPath::kEnclosed);
    EXPECT_EQ(result.path.end_yaw, yaw);
    EXPECT_LT(result.path.end.x(), at(map, 3.8, 0).x());
  }
}

/// The nearest place to a goal beside an obstacle often takes the body in one odd heading alone.
TEST(Planner, AnOpenYawNeverCostsMoreThanOneThatIsSaid) {
  Dice dice(19);
  int compared = 0, cheaper_end_farther = 0;
  for (int run = 0; run < 300; ++run) {
    const FloorMap map = random_floor(dice.whole(30, 60), dice.whole(30, 50), 0.05, dice);
    PlannerConfig config;
    config.start_is_free = false;
    config.near_price = 0;
    Planner planner(config, {}, kSmallBody, map.grid);
    const auto place = some_open_place(map, dice);
    if (!place) continue;
    const Pose2 start{place->x(), place->y(), dice.real(-3, 3)};
    Goal goal{some_place(map, dice), {}, 0.15};
    const auto open = planner.plan(map, start, goal);
    for (int h = 0; h < kHeadings; ++h) {
      goal.yaw = heading_angle(h);
      const auto said = planner.plan(map, start, goal);
      if (!said) continue;
      ASSERT_TRUE(open) << "run " << run << " heading " << h;
      ASSERT_LE(open.path.cost_s, said.path.cost_s + 1e-9) << "run " << run << " heading " << h;
      ASSERT_LE((open.path.end - goal.position).norm(), goal.tolerance);
      ++compared;
      cheaper_end_farther += (open.path.end - goal.position).norm() > 1e-9;
    }
  }
  EXPECT_GT(compared, 500);
  EXPECT_GT(cheaper_end_farther, 50);
}

TEST(Planner, LeavesAPlaceWhereSomethingCameTooNear) {
  FloorMap map = room();
  const Vector2d from = at(map, 4, 3.5);
  // 4 cm beside the left arm, and cells under the body that the map says are blocked.
  fill(map, {76, 77}, {84, 80}, Floor::kBlocked);
  fill(map, {78, 68}, {80, 70}, Floor::kBlocked);
  const Pose2 start{from.x(), from.y(), 0};
  Planner planner({}, {}, {}, map.grid);
  const auto result = planner.plan(map, start, {at(map, 6, 3.5), {}, 0.1});
  ASSERT_TRUE(result) << describe(result.reason);
  // But never through it, and not at all when the start's own place counts for nothing.
  const auto across = planner.plan(map, start, {at(map, 4, 4.6), {}, 0.1});
  ASSERT_TRUE(across);
  for (const PathState& s : across.path.states) {
    EXPECT_FALSE(s.cell.y() >= 77 && s.cell.y() <= 80 && s.cell.x() >= 70 && s.cell.x() <= 90);
  }
  EXPECT_GT(across.path.states.size(), 30u);
  PlannerConfig strict;
  strict.start_is_free = false;
  Planner stern(strict, {}, {}, map.grid);
  EXPECT_EQ(stern.plan(map, start, {at(map, 6, 3.5), {}, 0.1}).reason, NoPath::kStartBlocked);
}

TEST(Planner, PaysForUnseenFloorAndGoesAroundWhenThatIsCheaper) {
  FloorMap map = room();
  fill(map, {60, 40}, {100, 74}, Floor::kUnseen);
  const Vector2d from = at(map, 2, 3.5), to = at(map, 6, 3.5);
  const auto share_unseen = [&](double price) {
    PlannerConfig config;
    config.unseen_price = price;
    Planner planner(config, {}, {}, map.grid);
    const auto result = planner.plan(map, {from.x(), from.y(), 0}, {to, {}, 0.1});
    int unseen = 0;
    for (const PathState& s : result.path.states) unseen += map.at(s.cell) == Floor::kUnseen;
    return unseen;
  };
  EXPECT_GT(share_unseen(0.5), 35);
  EXPECT_EQ(share_unseen(20), 0);
}

TEST(Planner, OnlyTurnsWhenItIsThereAlready) {
  const FloorMap map = room();
  Planner planner({}, {}, {}, map.grid);
  const Vector2d here = at(map, 4, 3.5);
  const auto stay = planner.plan(map, {here.x(), here.y(), 0.4}, {here, {}, 0.1});
  ASSERT_TRUE(stay);
  EXPECT_EQ(stay.path.states.size(), 1u);
  EXPECT_EQ(stay.path.cost_s, 0);
  const auto turn = planner.plan(map, {here.x(), here.y(), 0.4}, {here, 0.4 + std::numbers::pi / 2, 0.1});
  ASSERT_TRUE(turn);
  EXPECT_EQ(turn.path.states.size(), 1u);
  EXPECT_NEAR(turn.path.cost_s, 14.4, 2e-3);
}

TEST(PlannerConfig, NamesTheKeyThatIsWrong) {
  PlannerConfig config;
  config.near_price = -2;
  try {
    config.validate();
    FAIL() << "a negative price passed";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("near_price"), std::string::npos);
  }
}

FloorMap read_moving_ai(const std::string& file) {
  std::ifstream in(file);
  std::string word;
  int width = 0, height = 0;
  in >> word >> word >> word >> height >> word >> width >> word;
  FloorMap map = free_floor(width, height, 1.0);
  map.grid.origin = {0, 0};
  for (int y = 0; y < height; ++y) {
    in >> word;
    for (int x = 0; x < width; ++x) {
      if (word[static_cast<std::size_t>(x)] != '.') fill(map, {x, y}, {x, y}, Floor::kBlocked);
    }
  }
  return map;
}

/// With a body of one point, no price on turns and none on nearness, the planner is an octile one that cuts
/// no corners.
void compare_with_listed_lengths(const std::string& name, int every) {
  const char* data = std::getenv("HEADWAY_DATA");
  if (data == nullptr) GTEST_SKIP() << "HEADWAY_DATA is not set: no Moving AI maps";
  const std::string file = std::string(data) + "/maps/" + name + ".map";
  const FloorMap map = read_moving_ai(file);
  PlannerConfig config;
  config.near_price = 0;
  config.turn_price = 0;
  config.start_is_free = false;
  config.ticks_per_cell = 70;  // and 99 for a diagonal
  Planner planner(config, {}, {0, 0, 0, 0}, map.grid);
  std::ifstream scenarios(file + ".scen");
  std::string line;
  std::getline(scenarios, line);
  int compared = 0;
  for (int number = 0; std::getline(scenarios, line); ++number) {
    if (number % every != 0) continue;
    std::istringstream fields(line);
    std::string word;
    double from_x = 0, from_y = 0, to_x = 0, to_y = 0, listed = 0;
    fields >> word >> word >> word >> word >> from_x >> from_y >> to_x >> to_y >> listed;
    const auto result = planner.plan(map, {from_x + 0.5, from_y + 0.5, 0}, {{to_x + 0.5, to_y + 0.5}, {}, 0});
    ASSERT_TRUE(result) << line << ": " << describe(result.reason);
    const double length = result.path.cost.walking / 4.0;  // 0.2 m in 0.8 s
    ASSERT_NEAR(length, listed, 0.01 + listed * 1e-4) << line;
    ++compared;
  }
  EXPECT_GE(compared, 10);
}

// All scenarios of both maps.
TEST(PlannerSlow, FindsEveryListedLengthInAGameMap) { compare_with_listed_lengths("bg512_AR0011SR", 1); }
TEST(PlannerSlow, FindsEveryListedLengthInBerlin) { compare_with_listed_lengths("cities_Berlin_0_512", 1); }
TEST(Planner, FindsTheListedLengthsInAGameMap) { compare_with_listed_lengths("bg512_AR0011SR", 120); }
TEST(Planner, FindsTheListedLengthsInBerlin) { compare_with_listed_lengths("cities_Berlin_0_512", 120); }

}  // namespace
}  // namespace headway::nav
