#include "nav/surveyed_floor.h"

#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/every_target.h"
#include "tests/nav/random_floor.h"
#include "tests/nav/textbook_search.h"

namespace headway::nav {
namespace {

using Eigen::Vector2i;

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
             static_cast<Floor>(dice.whole(0, 3)));
      }
    }
  }
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
