#include "nav/masks.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "nav/ground.h"
#include "nav/turn_room.h"
#include "tests/nav/cell_set.h"
#include "tests/nav/random_floor.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

/// Points of the outline's rim and inside, in the base frame, no farther apart than `spacing`: the rectangle,
/// grown by the clearance with round corners.
std::vector<Vector2d> sample_outline(const BodyOutline& o, double spacing) {
  std::vector<Vector2d> points;
  const double x_most = o.half_depth + o.clearance(), y_most = o.half_width + o.clearance();
  const int nx = static_cast<int>(std::ceil(2 * x_most / spacing)) + 1;
  const int ny = static_cast<int>(std::ceil(2 * y_most / spacing)) + 1;
  for (int i = 0; i <= nx; ++i) {
    for (int k = 0; k <= ny; ++k) {
      const Vector2d p(-x_most + 2 * x_most * i / nx, -y_most + 2 * y_most * k / ny);
      const double dx = std::max(0.0, std::abs(p.x()) - o.half_depth);
      const double dy = std::max(0.0, std::abs(p.y()) - o.half_width);
      if (std::hypot(dx, dy) <= o.clearance()) points.push_back(p);
    }
  }
  return points;
}

/// Where the base is during a motion that begins on the centre of cell (0, 0): it turns, then goes.
std::vector<Pose2> sample_motion(const Motion& m, double resolution, int samples) {
  std::vector<Pose2> poses;
  const double before = m.heading * std::numbers::pi / 4;
  const double turn = m.mode() == Mode::kForward ? m.turn() * std::numbers::pi / 4 : 0;
  const double direction = (m.heading + m.turn()) * std::numbers::pi / 4;
  const double length = resolution * ((m.heading + m.turn()) % 2 == 0 ? 1 : std::numbers::sqrt2);
  for (int i = 0; i <= samples; ++i) {
    const double t = static_cast<double>(i) / samples;
    if (turn != 0) poses.push_back({0, 0, before + t * turn});
    poses.push_back({t * length * std::cos(direction), t * length * std::sin(direction), before + turn});
  }
  return poses;
}

constexpr int kLowest = -60, kSide = 121;

Vector2i cell_of(const Vector2d& p, double resolution) {
  return {static_cast<int>(std::floor(p.x() / resolution + 0.5)),
          static_cast<int>(std::floor(p.y() / resolution + 0.5))};
}

CellSet cells_of(const Mask& mask) {
  CellSet cells(kLowest, kSide);
  for (const Mask::Run& run : mask.runs) {
    for (int x = run.first; x <= run.last; ++x) cells.insert({x, run.dy});
  }
  return cells;
}

CellSet sampled_cells(const BodyOutline& outline, const Motion& m, double resolution, double spacing) {
  CellSet cells(kLowest, kSide);
  const auto points = sample_outline(outline, spacing);
  for (const Pose2& pose : sample_motion(m, resolution, 60)) {
    const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
    for (const Vector2d& p : points) {
      cells.insert(cell_of({pose.x + c * p.x() - s * p.y(), pose.y + s * p.x() + c * p.y()}, resolution));
    }
  }
  return cells;
}

RC_GTEST_PROP(Motions, AllDifferAndNoneGoesBackward, ()) {
  const Motion m{*rc::gen::inRange(0, kHeadings), *rc::gen::inRange(0, kMotions)};
  RC_ASSERT(std::abs(m.turn()) <= 2);
  RC_ASSERT((m.mode() == Mode::kSideway) == (m.number >= 5));
  if (m.mode() == Mode::kSideway) RC_ASSERT(m.turn() != 0 && m.heading_after() == m.heading);
  if (m.mode() == Mode::kForward) RC_ASSERT(m.heading_after() == m.direction());
  for (int other = 0; other < m.number; ++other) {
    const Motion o{m.heading, other};
    RC_ASSERT(o.mode() != m.mode() || o.turn() != m.turn());
  }
}

TEST(Masks, HoldEveryPointThatTheSweptBodyCovers) {
  const BodyOutline hrp2;
  const Masks masks(hrp2, 0.05);
  for (int heading = 0; heading < kHeadings; ++heading) {
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{heading, number};
      ASSERT_TRUE(cells_of(masks.of(m)).includes(sampled_cells(hrp2, m, 0.05, 0.01)))
          << heading << " " << number;
    }
  }
}

TEST(Masks, HoldNoCellThatTheBodyStaysACentimetreAwayFrom) {
  const BodyOutline hrp2;
  BodyOutline wider = hrp2;
  wider.safety_margin += 0.01;
  const Masks masks(hrp2, 0.05);
  for (int heading = 0; heading < kHeadings; ++heading) {
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{heading, number};
      ASSERT_TRUE(sampled_cells(wider, m, 0.05, 0.005).includes(cells_of(masks.of(m))))
          << heading << " " << number;
    }
  }
}

TEST(Masks, OfOtherBodiesAndGridsHoldWhatTheyCoverToo) {
  rc::check([] {
    const auto length = [](int most) { return 0.01 * *rc::gen::inRange(0, most); };
    const BodyOutline outline{length(30), length(40), length(5), length(10)};
    const double resolution = *rc::gen::element(0.03, 0.05, 0.1, 0.2);
    const Motion m{*rc::gen::inRange(0, kHeadings), *rc::gen::inRange(0, kMotions)};
    // A point exactly between two cells belongs to both.
    BodyOutline inner = outline;
    inner.safety_margin = std::max(0.0, inner.safety_margin - 1e-9);
    const Masks masks(outline, resolution);
    for (const Vector2i& cell : sampled_cells(inner, m, resolution, 0.02).cells()) {
      RC_ASSERT(masks.of(m).contains(cell));
    }
  });
}

TEST(Masks, RefuseAGridTooFineForTheBody) { EXPECT_THROW(Masks(BodyOutline{}, 0.001), InputError); }

/// Turning HRP-2 by a right angle sweeps the corners of its outline past what neither end would touch.
TEST(TurnRoom, SeesWhatTheCornersSweepPast) {
  const BodyOutline body;
  FloorMap map = free_floor(60, 60, 0.05);
  const Vector2i centre(30, 30);
  const Vector2d place = map.grid.centre(centre);
  const auto can_turn = [&](const Vector2i& obstacle, double from, double to) {
    FloorMap with = map;
    with.cells[with.grid.index(obstacle)] = Floor::kBlocked;
    const GroundView ground(with, UnseenFloor::kFree, body, {-9, -9, 0}, false);
    const TurnRoom room(ground, body, place);
    EXPECT_TRUE(room.fits(from) && room.fits(to));
    return room.can_turn(from, to);
  };
  const Vector2i beside = centre + Vector2i(-1, 9);  // from 0.43 m on; arms end at 0.39 m, corners at 0.45 m
  EXPECT_FALSE(can_turn(beside, 0, std::numbers::pi / 2));
  EXPECT_FALSE(can_turn(beside, std::numbers::pi / 2, 0));
  EXPECT_TRUE(can_turn(centre + Vector2i(-1, 10), 0, std::numbers::pi / 2));
  EXPECT_TRUE(can_turn(beside, 0, 0.1));
}

/// Against every yaw on the way, finely sampled.
TEST(TurnRoom, AllowsATurnExactlyWhenTheBodyFitsAllTheWay) {
  const BodyOutline body;
  Dice dice(4);
  int free_turns = 0, blocked_turns = 0;
  for (int run = 0; run < 300; ++run) {
    FloorMap map = free_floor(40, 40, 0.05);
    const Vector2i obstacle(20 + dice.whole(-10, 11), 20 + dice.whole(-10, 11));
    map.cells[map.grid.index(obstacle)] = Floor::kBlocked;
    const Vector2d place =
        map.grid.centre({20, 20}) + Vector2d(dice.real(-0.02, 0.02), dice.real(-0.02, 0.02));
    const GroundView ground(map, UnseenFloor::kFree, body, {-9, -9, 0}, false);
    const double from = dice.real(-3, 3), turn = dice.real(-3, 3);
    double nearest = 1;
    for (int i = 0; i <= 2000; ++i) {
      const Pose2 base{place.x(), place.y(), from + turn * i / 2000};
      nearest = std::min(nearest, distance_to_square(body, base, map.grid.centre(obstacle), 0.05));
    }
    const bool can = TurnRoom(ground, body, place).can_turn(from, from + turn);
    if (nearest > body.clearance() + 0.006) {
      ASSERT_TRUE(can) << "run " << run;
    }
    if (nearest <= body.clearance()) {
      ASSERT_FALSE(can) << "run " << run;
    }
    ++(can ? free_turns : blocked_turns);
  }
  EXPECT_GT(free_turns, 50);
  EXPECT_GT(blocked_turns, 50);
}

TEST(BodyCells, AreThoseUnderTheOutlineAndOnTheGrid) {
  rc::check([] {
    const FloorGrid grid{0.05, {-0.3, 0.2}, 30, 25};
    const Pose2 base{*rc::gen::inRange(-100, 150) * 0.01, *rc::gen::inRange(-50, 200) * 0.01,
                     *rc::gen::inRange(-314, 314) * 0.01};
    CellSet cells(0, 30), must(0, 30), may(0, 30);
    for (const Vector2i& c : body_cells(grid, BodyOutline{}, base)) {
      RC_ASSERT(grid.contains(c));
      cells.insert(c);
    }
    const auto sampled = [&](const BodyOutline& o, CellSet& into) {
      for (const Vector2d& p : sample_outline(o, 0.005)) {
        const Vector2i c = grid.cell(base * p);
        if (grid.contains(c)) into.insert(c);
      }
    };
    sampled(BodyOutline{0.20, 0.31, 0.03, 0.0499}, must);
    sampled(BodyOutline{0.20, 0.31, 0.03, 0.06}, may);
    RC_ASSERT(cells.includes(must));
    RC_ASSERT(may.includes(cells));
  });
}

TEST(SoleCells, CoverTheSole) {
  const FloorGrid grid{0.05, {0, 0}, 40, 40};
  const auto cells = sole_cells(grid, GaitLimits{}, {1.0, 1.0, std::numbers::pi / 2});
  // 0.2172 m along y and 0.138 m along x, around a corner of four cells.
  EXPECT_EQ(cells.size(), 6u * 4u);
  EXPECT_EQ(cells.front(), Vector2i(18, 17));
  EXPECT_EQ(cells.back(), Vector2i(21, 22));
}

TEST(BodyOutline, NamesTheKeyThatIsWrong) {
  BodyOutline outline;
  outline.half_width = -1;
  try {
    outline.validate();
    FAIL() << "a negative width passed";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("half_width"), std::string::npos);
  }
}

}  // namespace
}  // namespace headway::nav
