#include "nav/surveyed_floor.h"

#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/every_target.h"
#include "tests/nav/random_floor.h"
#include "tests/nav/textbook_search.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d, Eigen::Vector2i;

struct Surveyor {
  PlannerConfig config;
  BodyOutline body;
  Masks masks, bare_masks;
  MotionCosts costs;
  SurveyedFloor floor;

  Surveyor(const PlannerConfig& c, const BodyOutline& b, double resolution)
      : config(c),
        body(b),
        masks(b, resolution),
        bare_masks(b.bare(), resolution),
        costs(c, {}, resolution),
        floor(masks, bare_masks, FloorPrices(c, {}, resolution, costs.tick), c.unseen) {}

  GroundView view(const FloorMap& map, const Pose2& start) const {
    return {map, config.unseen, body, start, config.start_is_free};
  }
  void update(const FloorMap& map, const Pose2& start = {}) { floor.update(map, view(map, start)); }
};

PlannerConfig any_config(Dice& dice) {
  PlannerConfig config;
  config.start_is_free = false;
  config.unseen = std::array{UnseenFloor::kBlocked, UnseenFloor::kCostly,
                             UnseenFloor::kFree}[static_cast<std::size_t>(dice.whole(0, 3))];
  config.near_price = dice.real(0, 3);
  config.near_range = dice.real(0.05, 1.2);
  config.corridor = dice.real(0, 0.4);
  return config;
}

BodyOutline any_body(Dice& dice) {
  return {dice.real(0, 0.3), dice.real(0, 0.5), dice.real(0, 0.05), dice.real(0, 0.1)};
}

/// Every bit and every price against masks and distances looked at cell by cell.
TEST(SurveyedFloor, SaysOfEachMotionWhatItsMaskAndTheCellsAroundSay) {
  Dice dice(21);
  int blocked = 0, open = 0, priced = 0;
  for (int run = 0; run < 40; ++run) {
    const double resolution = std::array{0.03, 0.05, 0.1}[static_cast<std::size_t>(dice.whole(0, 3))];
    const FloorMap map = random_floor(dice.whole(1, 300), dice.whole(1, 60), resolution, dice);
    Surveyor surveyor(any_config(dice), any_body(dice), resolution);
    surveyor.update(map);
    const TextbookSearch textbook(map, surveyor.config, {}, surveyor.masks);
    const FloorChunks& floor = surveyor.floor.chunks();
    for (int trial = 0; trial < 3000; ++trial) {
      const Vector2i c(dice.whole(0, map.grid.width), dice.whole(0, map.grid.height));
      const Motion m{dice.whole(0, kHeadings), dice.whole(0, kMotions)};
      const bool is_blocked = textbook.blocked(c, m);
      ASSERT_EQ(floor.blocked(c.x(), c.y(), m), is_blocked) << "run " << run << " at " << c.transpose();
      ++(is_blocked ? blocked : open);
      for (const bool diagonal : {false, true}) {
        ASSERT_EQ(floor.price(c.x(), c.y(), diagonal), textbook.price(c, diagonal)) << "run " << run;
        priced += textbook.price(c, diagonal) > 0;
      }
    }
  }
  EXPECT_GT(blocked, 10000);
  EXPECT_GT(open, 10000);
  EXPECT_GT(priced, 10000);
}

/// What may be stepped over, in bars and crumbs.
void scatter_low_ground(FloorMap& map, Dice& dice) {
  for (int bars = dice.whole(1, 8); bars > 0; --bars) {
    const Vector2i low(dice.whole(0, map.grid.width), dice.whole(0, map.grid.height));
    const Vector2i size = dice.whole(0, 2) == 0 ? Vector2i(1, 20) : Vector2i(20, 1);
    fill(map, low, low + Vector2i(dice.whole(0, size.x()), dice.whole(0, size.y())), Floor::kLow);
  }
}

bool meets_low(const FloorMap& map, const Mask& mask, const Vector2i& cell) {
  for (const Mask::Run& run : mask.runs)
    for (int x = run.first; x <= run.last; ++x) {
      const Vector2i c = cell + Vector2i(x, run.dy);
      if (map.grid.contains(c) && map.at(c) == Floor::kLow) return true;
    }
  return false;
}

TEST(SurveyedFloor, LetsTheBodyPassOverLowGroundOnlyStraightOnAndAtAPrice) {
  Dice dice(26);
  int over = 0, stopped = 0, priced = 0;
  for (int run = 0; run < 40; ++run) {
    const double resolution = std::array{0.03, 0.05, 0.1}[static_cast<std::size_t>(dice.whole(0, 3))];
    FloorMap map = random_floor(dice.whole(20, 200), dice.whole(20, 60), resolution, dice);
    scatter_low_ground(map, dice);
    Surveyor surveyor(any_config(dice), any_body(dice), resolution);
    surveyor.update(map);
    const TextbookSearch textbook(map, surveyor.config, {}, surveyor.masks);
    const Ticks low = FloorPrices(surveyor.config, {}, resolution, surveyor.costs.tick).low();
    ASSERT_GT(low, 0);
    const FloorChunks& floor = surveyor.floor.chunks();
    for (int trial = 0; trial < 3000; ++trial) {
      const Vector2i c(dice.whole(0, map.grid.width), dice.whole(0, map.grid.height));
      const Motion m{dice.whole(0, kHeadings), dice.whole(0, kMotions)};
      const bool straight_on = m.mode() == Mode::kForward && m.turn() == 0;
      const bool blocked = textbook.blocked(c, m), meets = meets_low(map, surveyor.masks.of(m), c);
      ASSERT_EQ(floor.blocked(c.x(), c.y(), m), blocked || (meets && !straight_on))
          << "run " << run << " at " << c.transpose() << ", motion " << m.number;
      over += meets && !blocked && straight_on;
      stopped += meets && !blocked && !straight_on;
      const bool is_low = map.at(c) == Floor::kLow;
      for (const bool diagonal : {false, true})
        ASSERT_EQ(floor.price(c.x(), c.y(), diagonal),
                  sum(textbook.price(c, diagonal), is_low ? low : Ticks{0}))
            << "run " << run << " at " << c.transpose();
      priced += is_low;
    }
  }
  EXPECT_GT(over, 500);
  EXPECT_GT(stopped, 5000);
  EXPECT_GT(priced, 1000);
}

/// Points of the body's rectangle at a pose, a millimetre or so from any other of its sides and a centimetre
/// from any inside.
std::vector<Vector2d> points_of(const BodyOutline& body, const Pose2& pose) {
  const auto raster = [](double half, double spacing) {
    std::vector<double> at;
    const int steps = static_cast<int>(std::ceil(2 * half / spacing)) + 1;
    for (int i = 0; i <= steps; ++i) at.push_back(half * (2.0 * i / steps - 1));
    return at;
  };
  std::vector<Vector2d> points;
  const auto add = [&](double x, double y) { points.emplace_back(pose * Vector2d(x, y)); };
  for (const double x : raster(body.half_depth, 0.01))
    for (const double y : raster(body.half_width, 0.01)) add(x, y);
  for (const double x : raster(body.half_depth, 0.002))
    for (const double y : {-body.half_width, body.half_width}) add(x, y);
  for (const double y : raster(body.half_width, 0.002))
    for (const double x : {-body.half_depth, body.half_depth}) add(x, y);
  return points;
}

/// What a cell is when the body stands where these points are; nothing where they lie too near to a limit to
/// tell.
std::optional<Ground> ground_by_points(const FloorMap& map, const PlannerConfig& config,
                                       const BodyOutline& body, const std::vector<Vector2d>& points,
                                       const Vector2i& cell) {
  constexpr double kUnsure = 0.002;
  if (!map.grid.contains(cell)) return Ground::kBlocked;
  const Floor floor = map.at(cell);
  const bool is_blocked =
      floor == Floor::kBlocked || (floor == Floor::kUnseen && config.unseen == UnseenFloor::kBlocked);
  if (!is_blocked) return Ground::kFree;  // as far as masks go
  double distance = 1e9;
  for (const Vector2d& p : points) {
    const Eigen::Array2d off = (p - map.grid.centre(cell)).array().abs() - map.grid.resolution / 2;
    distance = std::min(distance, off.max(0).matrix().norm());
  }
  if (distance == 0) return Ground::kFree;
  if (distance < kUnsure) return std::nullopt;
  const double limit = body.sway + body.safety_margin + map.grid.resolution * std::sqrt(0.5);
  if (std::abs(distance - limit) < kUnsure) return std::nullopt;
  return distance < limit ? Ground::kTight : Ground::kBlocked;
}

/// What came within its clearance must not nail the body to the spot: of such obstacles only the bare body
/// keeps off.
TEST(SurveyedFloor, KeepsNoClearanceFromWhatStandsWithinItAtTheStart) {
  Dice dice(25);
  int blocked = 0, open = 0, passed = 0;
  for (int run = 0; run < 40; ++run) {
    PlannerConfig config = any_config(dice);
    config.start_is_free = true;
    const BodyOutline body = any_body(dice);
    const double resolution = std::array{0.03, 0.05, 0.1}[static_cast<std::size_t>(dice.whole(0, 3))];
    const FloorMap map = random_floor(dice.whole(10, 60), dice.whole(10, 60), resolution, dice);
    const Vector2i from(dice.whole(0, map.grid.width), dice.whole(0, map.grid.height));
    const Vector2d at = map.grid.centre(from);
    const double off = resolution / 2;
    const Pose2 start{at.x() + dice.real(-off, off), at.y() + dice.real(-off, off), dice.real(-3, 3)};
    Surveyor surveyor(config, body, resolution);
    surveyor.update(map, start);
    const std::vector<Vector2d> points = points_of(body, start);
    std::map<std::pair<int, int>, std::optional<Ground>> known;
    const auto ground = [&](const Vector2i& cell) {
      const auto [place, is_new] = known.try_emplace({cell.x(), cell.y()});
      if (is_new) place->second = ground_by_points(map, config, body, points, cell);
      return place->second;
    };
    for (int trial = 0; trial < 200; ++trial) {
      const Vector2i c = (from + Vector2i(dice.whole(-3, 4), dice.whole(-3, 4)))
                             .cwiseMax(0)
                             .cwiseMin(Vector2i(map.grid.width - 1, map.grid.height - 1));
      const Motion m{dice.whole(0, kHeadings), dice.whole(0, kMotions)};
      bool unsure = false, meets = false, meets_tight = false;
      for (const auto& [mask, bare] :
           {std::pair(&surveyor.masks.of(m), false), std::pair(&surveyor.bare_masks.of(m), true)}) {
        for (const Mask::Run& run_of_cells : mask->runs) {
          for (int x = run_of_cells.first; x <= run_of_cells.last; ++x) {
            const auto g = ground(c + Vector2i(x, run_of_cells.dy));
            unsure |= !g;
            meets |= g == Ground::kBlocked || (bare && g == Ground::kTight);
            meets_tight |= g == Ground::kTight;
          }
        }
      }
      if (unsure) continue;
      ASSERT_EQ(surveyor.floor.chunks().blocked(c.x(), c.y(), m), meets)
          << "run " << run << " at " << c.transpose();
      ++(meets ? blocked : open);
      passed += !meets && meets_tight;
    }
  }
  EXPECT_GT(blocked, 1000);
  EXPECT_GT(open, 1000);
  EXPECT_GT(passed, 100) << "that keeping clear of all would have stopped";
}

void expect_equal(const SurveyedFloor& a, const SurveyedFloor& b) {
  const FloorChunks &fa = a.chunks(), &fb = b.chunks();
  for (int y = 0; y < fa.height(); ++y) {
    for (int i = 0; i < fa.chunks(); ++i) {
      ASSERT_EQ(fa.row(y)[i].blocked, fb.row(y)[i].blocked) << "row " << y << " chunk " << i;
      ASSERT_EQ(fa.passage(y)[i], fb.passage(y)[i]) << "row " << y << " chunk " << i;
      for (int x = i * kChunkCells; x < std::min(fa.width(), (i + 1) * kChunkCells); ++x)
        for (const bool diagonal : {false, true})
          ASSERT_EQ(fa.price(x, y, diagonal), fb.price(x, y, diagonal)) << x << " " << y;
    }
  }
}

/// Obstacles that come and go in any number of places, and a start that moves among tight ones.
TEST(SurveyedFloor, IsTheSameAfterChangesAsWhenSeenAnew) {
  Dice dice(22);
  for (int run = 0; run < 12; ++run) {
    PlannerConfig config = any_config(dice);
    config.start_is_free = run % 2 == 0;
    const BodyOutline body = any_body(dice);
    FloorMap map = random_floor(dice.whole(20, 400), dice.whole(20, 150), 0.05, dice);
    Surveyor changing(config, body, 0.05);
    for (int step = 0; step < 8; ++step) {
      const Vector2i at(dice.whole(0, map.grid.width), dice.whole(0, map.grid.height));
      const auto centre = map.grid.centre(at);
      const Pose2 start{centre.x(), centre.y(), dice.real(-3, 3)};
      changing.update(map, start);
      Surveyor fresh(config, body, 0.05);
      fresh.update(map, start);
      expect_equal(changing.floor, fresh.floor);
      if (HasFatalFailure()) return;
      for (int patches = dice.whole(0, 4); patches > 0; --patches) {
        const Vector2i low(dice.whole(0, map.grid.width), dice.whole(0, map.grid.height));
        fill(map, low, low + Vector2i(dice.whole(0, 8), dice.whole(0, 8)),
             static_cast<Floor>(dice.whole(0, 4)));
      }
    }
  }
}

/// Bit by bit and price by price, also where patches lie in rows far apart and the cells are small.
TEST(SurveyedFloor, TellsOfEachChunkThatHasChanged) {
  Dice dice(26);
  std::size_t changed = 0;
  for (int run = 0; run < 30; ++run) {
    const double resolution = std::array{0.02, 0.025, 0.05}[static_cast<std::size_t>(dice.whole(0, 3))];
    PlannerConfig config = any_config(dice);
    config.near_range = dice.real(0.05, 0.3);
    FloorMap map = random_floor(dice.whole(20, 300), dice.whole(60, 150), resolution, dice);
    Surveyor surveyor(config, {0.25, 0.35, 0.03, 0.05}, resolution);
    EXPECT_TRUE(surveyor.floor.update(map, surveyor.view(map, {})).everything);
    for (int step = 0; step < 5; ++step) {
      const FloorChunks before = surveyor.floor.chunks();
      Vector2i low(dice.whole(0, map.grid.width), dice.whole(0, map.grid.height));
      for (int patches = dice.whole(1, 4); patches > 0; --patches) {
        fill(map, low, low + Vector2i(dice.whole(0, 8), dice.whole(0, 8)),
             static_cast<Floor>(dice.whole(0, 4)));
        low = {dice.whole(0, map.grid.width), (low.y() + dice.whole(28, 52)) % map.grid.height};
      }
      const FloorChanges& told = surveyor.floor.update(map, surveyor.view(map, {}));
      EXPECT_FALSE(told.everything);
      std::map<std::pair<int, int>, std::pair<unsigned, bool>> listed;
      for (const ChunkChange& c : told.chunks) {
        auto& [raised, lowered] = listed[{c.y, c.i}];
        raised |= c.raised;
        lowered |= c.lowered;
      }
      const FloorChunks& now = surveyor.floor.chunks();
      for (int y = 0; y < map.grid.height; ++y) {
        for (int x = 0; x < map.grid.width; ++x) {
          bool raised = false, lowered = false;
          for (int slot = 0; slot < kConfigurations; ++slot) {
            raised |= now.blocked(x, y, slot) && !before.blocked(x, y, slot);
            lowered |= !now.blocked(x, y, slot) && before.blocked(x, y, slot);
          }
          for (const bool diagonal : {false, true}) {
            raised |= now.price(x, y, diagonal) > before.price(x, y, diagonal);
            lowered |= now.price(x, y, diagonal) < before.price(x, y, diagonal);
          }
          const auto found = listed.find({y, x / kChunkCells});
          const auto [cells, any] = found == listed.end() ? std::pair(0u, false) : found->second;
          ASSERT_TRUE(!raised || (cells >> (x % kChunkCells) & 1))
              << "run " << run << " at " << x << " " << y;
          ASSERT_TRUE(!lowered || any) << "run " << run << " at " << x << " " << y;
          changed += raised || lowered;
        }
      }
    }
  }
  EXPECT_GT(changed, 50000u);
}

TEST(SurveyedFloor, IsTheSameOnEveryInstructionSet) {
  Dice dice(23);
  for (int run = 0; run < 6; ++run) {
    const FloorMap map = random_floor(dice.whole(1, 600), dice.whole(1, 80), 0.05, dice);
    const PlannerConfig config = any_config(dice);
    const BodyOutline body = any_body(dice);
    hwy::GetChosenTarget().Update(HWY_SCALAR);
    Surveyor plain(config, body, 0.05);
    plain.update(map);
    headway::test::on_every_target([&](const std::string& name) {
      SCOPED_TRACE(name);
      Surveyor other(config, body, 0.05);
      other.update(map);
      expect_equal(plain.floor, other.floor);
    });
  }
}

TEST(FloorPrices, AreThoseOfTheTextbookAsFarAsARangeMaySpan) {
  Dice dice(24);
  for (const int cells : {180, 181, 215, 250}) {
    PlannerConfig config;
    config.start_is_free = false;
    config.near_range = 0.01 * cells;
    FloorMap map = random_floor(640, 3, 0.01, dice);
    std::fill(map.cells.begin(), map.cells.end(), Floor::kFree);
    map.cells[map.grid.index({300, 1})] = Floor::kBlocked;
    Surveyor surveyor(config, {0.01, 0.01, 0, 0}, 0.01);
    surveyor.update(map);
    const TextbookSearch textbook(map, config, {}, surveyor.masks);
    for (int x = 0; x < map.grid.width; ++x)
      ASSERT_EQ(surveyor.floor.chunks().price(x, 1, false), textbook.price({x, 1}, false))
          << cells << ": " << x;
  }
}

TEST(FloorPrices, RefuseARangeOfTooManyCells) {
  PlannerConfig config;
  config.near_range = 3;
  EXPECT_THROW(FloorPrices(config, {}, 0.01, 0.01), InputError);
}

}  // namespace
}  // namespace headway::nav
