#include "nav/path_search.h"

#include <limits>
#include <queue>
#include <vector>

#include <gtest/gtest.h>

#include "nav/surveyed_floor.h"
#include "tests/every_target.h"
#include "tests/nav/random_floor.h"
#include "tests/nav/textbook_search.h"

namespace headway::nav {
namespace {

using Eigen::Vector2i;

constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();

/// A small robot on a floor with all that its search needs.
struct Floorplan {
  FloorMap map;
  PlannerConfig config;
  Masks masks, bare_masks;
  MotionCosts costs;
  SurveyedFloor floor;

  Floorplan(FloorMap m, const PlannerConfig& c, const BodyOutline& body)
      : map(std::move(m)),
        config(c),
        masks(body, map.grid.resolution),
        bare_masks(body.bare(), map.grid.resolution),
        costs(c, {}, map.grid.resolution),
        floor(masks, bare_masks, FloorPrices(c, {}, map.grid.resolution, costs.tick), c.unseen) {
    config.start_is_free = false;
    update();
  }
  const FloorChanges& update() { return floor.update(map, GroundView(map, config.unseen, {}, {}, false)); }
  TextbookSearch textbook() const { return {map, config, {}, masks}; }
};

PlannerConfig any_config(Dice& dice) {
  PlannerConfig config;
  config.near_price = dice.whole(0, 3);
  config.near_range = dice.real(0.05, 0.7);
  config.turn_price = dice.real(0, 1.5);
  config.mode_change = dice.real(0, 3);
  config.ticks_per_cell = dice.whole(3, 40);
  return config;
}

/// Mostly between cells from which some motion is free.
CostQuery any_query(const Floorplan& plan, Dice& dice, int most_goals = 3) {
  const auto cell = [&] {
    Vector2i c;
    for (int trial = 0; trial < 20; ++trial) {
      c = {dice.whole(0, plan.map.grid.width), dice.whole(0, plan.map.grid.height)};
      int free = 0;
      for (int slot = 0; slot < kConfigurations; ++slot)
        free += !plan.floor.chunks().blocked(c.x(), c.y(), slot);
      if (free > 0) break;
    }
    return c;
  };
  CostQuery query;
  query.start = cell();
  const auto turn = [&] { return dice.whole(0, 4) ? static_cast<Ticks>(dice.whole(0, 800)) : kTooDear; };
  for (Ticks& cost : query.start_cost) cost = turn();
  for (int more = dice.whole(0, most_goals); more >= 0; --more) {
    Arrival goal{cell(), {}};
    for (Ticks& cost : goal.cost) cost = turn();
    if (std::ranges::find(query.goals, goal.cell, &Arrival::cell) == query.goals.end())
      query.goals.push_back(goal);
  }
  return query;
}

/// A state's cost by the best of what can be done there, from the costs of where that leads.
template <class CostOf>
std::uint32_t by_best_successor(const TextbookSearch& textbook, const CostQuery& query, const Vector2i& cell,
                                int heading, Mode mode, const CostOf& cost_of) {
  std::uint32_t best = query.arrival_cost(cell, heading);
  const Mode other = mode == Mode::kForward ? Mode::kSideway : Mode::kForward;
  best = std::min(best, cost_of(cell, heading, other) + textbook.mode_change());
  for (int number = 0; number < kMotions; ++number) {
    const Motion m{heading, number};
    if (m.mode() != mode || textbook.blocked(cell, m)) continue;
    best = std::min(best, cost_of(cell + cell_towards(m.direction()), m.heading_after(), mode) +
                              textbook.motion(cell, m));
  }
  return best;
}

/// Dijkstra from the start, forwards: it shares neither direction nor order with the sweeps.
std::uint32_t cheapest(const TextbookSearch& textbook, const FloorGrid& grid, const CostQuery& query) {
  std::vector<std::uint32_t> known(grid.size() * kLayers, kTooDear);
  using Entry = std::pair<std::uint32_t, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto reach = [&](const Vector2i& c, int heading, Mode mode, std::uint32_t cost) {
    const std::size_t id = grid.index(c) * kLayers + static_cast<std::size_t>(layer_of(heading, mode));
    if (cost >= known[id]) return;
    known[id] = cost;
    open.push({cost, id});
  };
  for (int h = 0; h < kHeadings; ++h)
    for (const Mode mode : {Mode::kForward, Mode::kSideway})
      reach(query.start, h, mode, query.start_cost[static_cast<std::size_t>(h)]);
  std::uint32_t best = kTooDear;
  while (!open.empty()) {
    const auto [cost, id] = open.top();
    open.pop();
    if (cost != known[id]) continue;
    const auto layer = static_cast<int>(id % kLayers), cell = static_cast<int>(id / kLayers);
    const int heading = layer % kHeadings;
    const Mode mode = layer < kHeadings ? Mode::kForward : Mode::kSideway;
    const Vector2i c(cell % grid.width, cell / grid.width);
    best = std::min(best, cost + query.arrival_cost(c, heading));
    reach(c, heading, mode == Mode::kForward ? Mode::kSideway : Mode::kForward,
          cost + textbook.mode_change());
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{heading, number};
      if (m.mode() != mode || textbook.blocked(c, m)) continue;
      reach(c + cell_towards(m.direction()), m.heading_after(), mode, cost + textbook.motion(c, m));
    }
  }
  return best;
}

/// Walks a found path again, motion by motion.
void walk_again(const PathSearch::Found& found, const TextbookSearch& textbook, const CostQuery& query) {
  ASSERT_EQ(found.states.size(), found.cost_so_far.size());
  ASSERT_EQ(found.states.front().cell, query.start);
  ASSERT_EQ(found.cost_so_far.front(),
            query.start_cost[static_cast<std::size_t>(found.states.front().heading)]);
  for (std::size_t i = 1; i < found.states.size(); ++i) {
    const PathState &a = found.states[i - 1], &b = found.states[i];
    const std::uint32_t cost = found.cost_so_far[i] - found.cost_so_far[i - 1];
    if (a.cell == b.cell) {
      ASSERT_TRUE(a.heading == b.heading && a.mode != b.mode && cost == textbook.mode_change());
      continue;
    }
    bool matches = false;
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{a.heading, number};
      matches |= m.mode() == a.mode && a.mode == b.mode && m.heading_after() == b.heading &&
                 a.cell + cell_towards(m.direction()) == b.cell && !textbook.blocked(a.cell, m) &&
                 textbook.motion(a.cell, m) == cost;
    }
    ASSERT_TRUE(matches) << "state " << i << " of " << found.states.size();
  }
  const Ticks arrival = query.arrival_cost(found.states.back().cell, found.states.back().heading);
  ASSERT_NE(arrival, kTooDear);
  ASSERT_EQ(found.cost, found.cost_so_far.back() + arrival);
}

constexpr BodyOutline kSmallBody{0.10, 0.16, 0.02, 0.03};

/// More than a thousand queries on random floors, each once cold, once after patches that come, once after
/// patches that go, and once when only the first answer is wanted.
TEST(PathSearch, CostsWhatTheTextbookSaysAndCanBeWalkedAgain) {
  Dice dice(31);
  int found_all = 0, none = 0, queries = 0;
  for (int run = 0; run < 130; ++run) {
    Floorplan plan(random_floor(dice.whole(10, 70), dice.whole(10, 50), 0.08, dice), any_config(dice),
                   kSmallBody);
    PathSearch search(plan.floor.chunks(), plan.costs);
    std::uint32_t expected = 0;
    for (int trial = 0; trial < 8; ++trial, ++queries) {
      const CostQuery query = any_query(plan, dice);
      const TextbookSearch textbook = plan.textbook();
      const std::uint32_t cost = cheapest(textbook, plan.map.grid, query);
      const auto found = search.run(query, kUnlimited, expected);
      ASSERT_EQ(found.has_value(), cost != kTooDear) << "run " << run << " trial " << trial;
      ++(found ? found_all : none);
      if (found) {
        ASSERT_EQ(found->cost, cost) << "run " << run << " trial " << trial;
        ASSERT_EQ(found->bound, 1);
        walk_again(*found, textbook, query);
        if (HasFatalFailure()) return;
        const auto first = search.run(query, 0, expected);
        ASSERT_TRUE(first);
        walk_again(*first, textbook, query);
        if (HasFatalFailure()) return;
        ASSERT_LE(first->cost, 1.0625 * cost);
      }
      expected = dice.whole(0, 2) && found ? found->cost + 100 : 0;
      const Vector2i low(dice.whole(0, plan.map.grid.width), dice.whole(0, plan.map.grid.height));
      fill(plan.map, low, low + Vector2i(dice.whole(0, 6), dice.whole(0, 6)),
           dice.whole(0, 2) ? Floor::kFree : Floor::kBlocked);
      search.floor_changed(plan.update());
    }
  }
  EXPECT_GE(queries, 1000);
  EXPECT_GT(found_all, 400);
  EXPECT_GT(none, 100);
}

/// The same goals while obstacles come and go anywhere and the start moves: costs kept from query to query
/// must not be told from costs found anew, whatever part of them an earlier query left undone.
TEST(PathSearch, GoesOnFromTheLastQueryAsIfBegunAnew) {
  Dice dice(36);
  int found_all = 0, none = 0, spared = 0;
  for (int run = 0; run < 30; ++run) {
    Floorplan plan(random_floor(dice.whole(10, 90), dice.whole(10, 60), 0.08, dice), any_config(dice),
                   kSmallBody);
    PathSearch search(plan.floor.chunks(), plan.costs);
    const CostQuery to = any_query(plan, dice);
    for (int trial = 0; trial < 25; ++trial) {
      CostQuery query = any_query(plan, dice);
      query.goals = to.goals;
      const std::uint32_t cost = cheapest(plan.textbook(), plan.map.grid, query);
      const auto expected = static_cast<std::uint32_t>(dice.whole(0, 3) ? 0 : dice.whole(1, 3000));
      const std::size_t budget =
          dice.whole(0, 3) == 0 ? static_cast<std::size_t>(dice.whole(0, 60)) : kUnlimited;
      const auto found = search.run(query, budget, expected);
      ASSERT_EQ(found.has_value(), cost != kTooDear) << "run " << run << " trial " << trial;
      ++(found ? found_all : none);
      if (found) {
        ASSERT_LE(found->cost, found->bound * cost) << "run " << run << " trial " << trial;
        ASSERT_GE(found->cost, cost) << "run " << run << " trial " << trial;
        walk_again(*found, plan.textbook(), query);
        if (HasFatalFailure()) return;
        if (found->bound == 1) {
          const auto fresh = PathSearch(plan.floor.chunks(), plan.costs).run(query, kUnlimited);
          ASSERT_EQ(found->states, fresh->states) << "run " << run << " trial " << trial;
          spared += found->relaxed < fresh->relaxed / 2;
        }
      }
      for (int updates = dice.whole(0, 3); updates > 0; --updates) {
        const Vector2i low(dice.whole(0, plan.map.grid.width), dice.whole(0, plan.map.grid.height));
        fill(plan.map, low, low + Vector2i(dice.whole(0, 6), dice.whole(0, 6)),
             static_cast<Floor>(dice.whole(0, 3)));
        search.floor_changed(plan.update());
      }
    }
  }
  EXPECT_GT(found_all, 400);
  EXPECT_GT(none, 100);
  EXPECT_GT(spared, 100);
}

/// Long ways around walls, where much may be left out.
TEST(PathSearch, FirstPathsKeepTheBound) {
  Dice dice(35);
  double worst = 1;
  for (int run = 0; run < 40; ++run) {
    FloorMap map = free_floor(dice.whole(200, 320), dice.whole(150, 240), 0.08);
    for (int wall = 0; wall < 30; ++wall) {
      const Vector2i low(dice.whole(0, map.grid.width), dice.whole(0, map.grid.height));
      const int length = dice.whole(10, 90);
      fill(map, low, low + (dice.whole(0, 2) ? Vector2i(length, 1) : Vector2i(1, length)), Floor::kBlocked);
    }
    Floorplan plan(std::move(map), any_config(dice), kSmallBody);
    PathSearch search(plan.floor.chunks(), plan.costs);
    for (int trial = 0; trial < 10; ++trial) {
      const CostQuery query = any_query(plan, dice, 1);
      const auto first = search.run(query, 0), best = search.run(query, kUnlimited);
      ASSERT_EQ(first.has_value(), best.has_value());
      if (!first) continue;
      ASSERT_LE(16 * first->cost, 17 * best->cost);
      ASSERT_GE(first->cost, best->cost);
      worst = std::max(worst, static_cast<double>(first->cost) / std::max(1u, best->cost));
    }
  }
  EXPECT_GT(worst, 1);  // else the bound was not put to the test
}

/// Every state that may lie on the cheapest way, against its best successor. Returns how many there were.
std::size_t audit(const CostToGoal& costs, const Floorplan& plan, const CostQuery& query) {
  const TextbookSearch textbook = plan.textbook();
  const auto cost_of = [&](const Vector2i& c, int heading, Mode mode) {
    return std::uint32_t{costs.at(c.x(), c.y(), layer_of(heading, mode))};
  };
  std::size_t audited = 0, wrong = 0;
  for (int y = 0; y < plan.map.grid.height; ++y) {
    for (int x = 0; x < plan.map.grid.width; ++x) {
      const Vector2i c(x, y), way = (c - query.start).cwiseAbs();
      const int both = way.minCoeff(), more = way.maxCoeff() - both;
      const std::uint32_t least =
          static_cast<std::uint32_t>(more * plan.costs.least[0] + both * plan.costs.least[1]);
      for (int layer = 0; layer < kLayers; ++layer) {
        const Mode mode = layer < kHeadings ? Mode::kForward : Mode::kSideway;
        const std::uint32_t cost = cost_of(c, layer % kHeadings, mode);
        const std::uint32_t best = by_best_successor(textbook, query, c, layer % kHeadings, mode, cost_of);
        wrong += cost < best;
        if (best == kTooDear || best + least >= costs.at_start()) continue;
        wrong += cost != best;
        ++audited;
      }
    }
  }
  EXPECT_EQ(wrong, 0U) << "of " << audited;
  return audited;
}

/// Also when costs are kept while the floor changes.
TEST(CostToGoal, OfEachStateThatMattersIsThatOfItsBestSuccessor) {
  Dice dice(32);
  std::size_t audited = 0;
  for (int run = 0; run < 60; ++run) {
    Floorplan plan(random_floor(dice.whole(10, 120), dice.whole(10, 60), 0.08, dice), any_config(dice),
                   kSmallBody);
    CostToGoal costs(plan.floor.chunks(), plan.costs);
    const CostQuery query = any_query(plan, dice);
    for (int change = 0; change < 4; ++change) {
      costs.begin(query);
      ASSERT_TRUE(costs.settle(16, kUnlimited));
      audited += audit(costs, plan, query);
      ASSERT_FALSE(HasFailure()) << "run " << run << " after " << change << " changes";
      const Vector2i low(dice.whole(0, plan.map.grid.width), dice.whole(0, plan.map.grid.height));
      fill(plan.map, low, low + Vector2i(dice.whole(0, 6), dice.whole(0, 6)),
           static_cast<Floor>(dice.whole(0, 3)));
      costs.floor_changed(plan.update());
    }
  }
  EXPECT_GT(audited, 100000u);
}

TEST(PathSearch, IsTheSameOnEveryInstructionSet) {
  Dice dice(33);
  for (int run = 0; run < 12; ++run) {
    Floorplan plan(random_floor(dice.whole(10, 200), dice.whole(10, 90), 0.08, dice), any_config(dice),
                   kSmallBody);
    const CostQuery query = any_query(plan, dice);
    for (const std::size_t budget : {std::size_t{0}, std::size_t{100}, kUnlimited}) {
      hwy::GetChosenTarget().Update(HWY_SCALAR);
      const auto plain = PathSearch(plan.floor.chunks(), plan.costs).run(query, budget);
      headway::test::on_every_target([&](const std::string& name) {
        const auto other = PathSearch(plan.floor.chunks(), plan.costs).run(query, budget);
        ASSERT_EQ(other.has_value(), plain.has_value()) << name;
        if (!plain) return;
        EXPECT_EQ(other->states, plain->states) << name;
        EXPECT_EQ(other->cost_so_far, plain->cost_so_far) << name;
        EXPECT_EQ(other->relaxed, plain->relaxed) << name;
        EXPECT_EQ(other->bound, plain->bound) << name;
      });
    }
  }
}

/// Also when it goes on after a change of the floor.
TEST(PathSearch, GoesOnAlikeOnEveryInstructionSet) {
  Dice dice(37);
  for (int run = 0; run < 8; ++run) {
    const Floorplan plan(random_floor(dice.whole(10, 120), dice.whole(10, 60), 0.08, dice), any_config(dice),
                         kSmallBody);
    const CostQuery query = any_query(plan, dice);
    std::vector<Vector2i> patches;
    for (int patch = 0; patch < 4; ++patch)
      patches.emplace_back(dice.whole(0, plan.map.grid.width), dice.whole(0, plan.map.grid.height));
    const auto work = [&] {
      Floorplan own(plan.map, plan.config, kSmallBody);
      PathSearch search(own.floor.chunks(), own.costs);
      std::vector<std::size_t> relaxed;
      for (std::size_t i = 0; i < patches.size(); ++i) {
        const auto found = search.run(query, kUnlimited);
        relaxed.push_back(search.to_goal().relaxed());
        if (found) relaxed.push_back(found->cost);
        fill(own.map, patches[i], patches[i] + Vector2i(4, 4), i % 2 ? Floor::kFree : Floor::kBlocked);
        search.floor_changed(own.update());
      }
      return relaxed;
    };
    hwy::GetChosenTarget().Update(HWY_SCALAR);
    const auto plain = work();
    headway::test::on_every_target([&](const std::string& name) { EXPECT_EQ(work(), plain) << name; });
  }
}

/// Whatever was searched before, and whatever was expected, the optimum is the same path.
TEST(PathSearch, FindsTheSameOptimumFromEveryPast) {
  Dice dice(34);
  for (int run = 0; run < 20; ++run) {
    Floorplan plan(random_floor(120, 60, 0.08, dice), any_config(dice), kSmallBody);
    const CostQuery query = any_query(plan, dice);
    PathSearch used(plan.floor.chunks(), plan.costs);
    const auto fresh = PathSearch(plan.floor.chunks(), plan.costs).run(query, kUnlimited);
    for (int trial = 0; trial < 4; ++trial) {
      used.run(any_query(plan, dice), dice.whole(0, 2) ? kUnlimited : 0);
      const auto again = used.run(query, kUnlimited, static_cast<std::uint32_t>(dice.whole(1, 3000)));
      ASSERT_EQ(again.has_value(), fresh.has_value());
      if (!fresh) continue;
      ASSERT_EQ(again->states, fresh->states) << "run " << run;
      ASSERT_EQ(again->cost_so_far, fresh->cost_so_far);
    }
  }
}

TEST(PathSearch, KeepsToItsBudget) {
  Floorplan plan(free_floor(400, 300, 0.05), {}, kSmallBody);
  CostQuery query;
  query.start = {30, 40};
  query.goals = {{{370, 250}, {}}};
  const auto run = [&](std::size_t budget) {
    return PathSearch(plan.floor.chunks(), plan.costs).run(query, budget);
  };
  const auto first = run(0), some = run(50), best = run(kUnlimited);
  ASSERT_TRUE(first && some && best);
  EXPECT_EQ(first->bound, 1.0625);
  EXPECT_EQ(first->relaxed, first->first_relaxed);
  EXPECT_EQ(some->first_relaxed, first->first_relaxed);
  EXPECT_LT(some->relaxed, some->first_relaxed + 50 + 200);  // looked at after each row
  EXPECT_EQ(best->bound, 1);
  EXPECT_LE(best->cost, some->cost);
  EXPECT_LE(some->cost, first->cost);
}

}  // namespace
}  // namespace headway::nav
