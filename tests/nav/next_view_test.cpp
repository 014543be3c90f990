#include "nav/next_view.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "nav/explored.h"
#include "nav/integrate.h"
#include "random_view.h"
#include "room_map.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
using hal::HeadAngles;

constexpr double kTanX = 0.29, kTanY = 0.29;

/// HRP-2's neck, with a camera in its middle.
Viewer viewer() {
  Viewer v;
  v.field = rig_field(kTanX, kTanY, 0.5, 5, 0);
  v.neck.chest_from_pan.translation().z() = 0.33;
  v.neck.tilt_from_camera.linear() = hal::body_from_optical(10 * kDegree);
  return v;
}

const Isometry3d kChest = Pose2{-1.2, 0, 0}.lifted(1.0);

bool same(const HeadAngles& a, const HeadAngles& b) { return a.pan == b.pan && a.tilt == b.tilt; }

/// What is known of a room that nobody has looked at, but for the air in it.
VoxelMap known_air(const SyntheticRoom& room) {
  VoxelMap map = room_map(0.1);
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    const VoxelMap::Index first = 8 * map.brick_at(b);
    for (int i = 0; i < 512; ++i) {
      const Vector3d centre = map.centre(first + VoxelMap::Index(i & 7, i >> 3 & 7, i >> 6));
      map.edit(b)[static_cast<std::size_t>(VoxelMap::in_brick(i & 7, i >> 3 & 7, i >> 6))] =
          room.clearance(centre) > 0 ? log_odds::kLowest : log_odds::kHighest;
    }
    map.settle(b, Time{});
  }
  return map;
}

// Rest to rest at the limits, integrated in small steps.
double simulated_seconds(double way, const hal::HeadLimits& limits) {
  constexpr double kStep = 1e-4;
  double at = 0, speed = 0, t = 0;
  while (way - at > 1e-5) {
    const double stopping = speed * speed / (2 * limits.acceleration);
    speed = way - at > stopping ? std::min(limits.velocity, speed + kStep * limits.acceleration)
                                : std::max(1e-3, speed - kStep * limits.acceleration);
    at += kStep * speed;
    t += kStep;
  }
  return t;
}

RC_GTEST_PROP(HeadSeconds, AreThoseOfTheSlowerJointFromRestToRest, ()) {
  hal::HeadLimits limits;
  limits.velocity = between(0.3, 2);
  limits.acceleration = between(1, 8);
  const HeadAngles from{between(-0.7, 0.7), between(-0.5, 0.7)}, to{between(-0.7, 0.7), between(-0.5, 0.7)};
  const double expected = std::max(simulated_seconds(std::abs(to.pan - from.pan), limits),
                                   simulated_seconds(std::abs(to.tilt - from.tilt), limits));
  RC_ASSERT(std::abs(head_seconds(from, to, limits) - expected) < 0.02);
  RC_ASSERT(head_seconds(from, to, limits) == head_seconds(to, from, limits));
  RC_ASSERT(head_seconds(from, from, limits) == 0.0);
}

TEST(NextView, TriesDirectionsHalfAFieldApartToTheEndsOfTheNeck) {
  const Viewer v = viewer();
  const NextView next(v, 0.05);
  double low_pan = 0, high_pan = 0, low_tilt = 0, high_tilt = 0;
  for (const HeadAngles& d : next.directions()) {
    low_pan = std::min(low_pan, d.pan);
    high_pan = std::max(high_pan, d.pan);
    low_tilt = std::min(low_tilt, d.tilt);
    high_tilt = std::max(high_tilt, d.tilt);
    double nearest = 10;
    for (const HeadAngles& e : next.directions())
      if (!same(d, e)) nearest = std::min(nearest, std::hypot(d.pan - e.pan, d.tilt - e.tilt));
    EXPECT_LE(nearest, std::atan(kTanX) + 1e-9);
  }
  EXPECT_EQ(low_pan, v.head.lower.pan);
  EXPECT_EQ(high_pan, v.head.upper.pan);
  EXPECT_EQ(low_tilt, v.head.lower.tilt);
  EXPECT_EQ(high_tilt, v.head.upper.tilt);
}

TEST(NextView, WantsNothingWhereAllIsKnown) {
  const VoxelMap map = known_air(SyntheticRoom::furnished());
  EXPECT_TRUE(NextView(viewer(), 0.1).turns(map, kChest, {}).empty());
}

RC_GTEST_PROP(NextView, LooksAtTheOnlyPlaceThatIsUnseen, ()) {
  const SyntheticRoom room;
  VoxelMap map = known_air(room);
  const Vector3d place = kChest * viewer().neck.chest_from_camera({between(-0.7, 0.7), between(-0.3, 0.6)}) *
                         Vector3d(0, 0, between(1.0, 1.5));
  const VoxelMap::Index i = map.index(place);
  fill(map, i - VoxelMap::Index(2, 2, 2), i + VoxelMap::Index(3, 3, 3), log_odds::kUnseen);
  NextViewConfig config;
  config.space = {-1, 3};
  config.least_gain = 0.02;
  NextView next(viewer(), 0.1, config);
  const auto looks = next.turns(map, kChest, {});
  RC_ASSERT(!looks.empty());
  const auto field =
      vision::moved(next.viewer().field, kChest * next.viewer().neck.chest_from_camera(looks[0].head));
  RC_ASSERT(field.contains(place, 0.25));
}

RC_GTEST_PROP(NextView, PutsTheMostGainPerSecondFirstAndLeavesOutWhatIsNotWorthIt, ()) {
  const RandomView r = any_view();
  NextViewConfig config;
  config.space = {-1, 3};
  config.least_gain = between(0.001, 0.2);
  NextView next(viewer(), r.map.resolution(), config);
  const HeadAngles head{between(-0.7, 0.7), between(-0.5, 0.7)};
  const Isometry3d chest = Pose2{between(-1, 1), between(-1, 1), between(-3, 3)}.lifted(0.8);
  const auto looks = next.turns(r.map, chest, head);
  ViewGain gain(next.viewer().field, r.map.resolution(), config.space);
  const auto gain_of = [&](const HeadAngles& d) {
    return static_cast<double>(gain.gain(r.map, chest * next.viewer().neck.chest_from_camera(d))) *
           std::pow(r.map.resolution(), 3);
  };
  for (std::size_t i = 0; i < looks.size(); ++i) {
    RC_ASSERT(looks[i].gain == gain_of(looks[i].head));
    RC_ASSERT(looks[i].gain >= config.least_gain);
    RC_ASSERT(looks[i].seconds ==
              head_seconds(head, looks[i].head, next.viewer().head) + config.look_seconds);
    RC_ASSERT((i == 0 || looks[i].rate() <= looks[i - 1].rate()));  // the macro would look at both sides
  }
  std::size_t worth = 0;
  for (const HeadAngles& d : next.directions()) worth += gain_of(d) >= config.least_gain;
  RC_ASSERT(worth == looks.size());
}

/// Looks until nothing is left to gain, with eyes that see only when not `blind`.
struct Exploration {
  VoxelMap map = room_map();
  double seconds = 0;
  std::vector<Isometry3d> looked;

  explicit Exploration(const SyntheticRoom& room, bool blind = false) {
    const vision::PinholeCamera camera = camera_of(170, 170, 2 * std::atan(kTanX));
    NextView next(viewer(), 0.05);
    HeadAngles head;
    Integrator integrator;
    for (auto looks = next.turns(map, kChest, head); !looks.empty() && looked.size() < 100;
         looks = next.turns(map, kChest, head, looked)) {
      seconds += looks[0].seconds;
      head = looks[0].head;
      looked.push_back(kChest * next.viewer().neck.chest_from_camera(head));
      if (!blind) integrator.integrate(map, look(room, camera, looked.back()), looked.back(), Time{});
    }
  }
};

TEST(NextView, SeesAllThatTheHeadCanShowWithFewLooks) {
  const SyntheticRoom room = SyntheticRoom::furnished();
  const Exploration chosen(room);
  VoxelMap all = room_map();
  const vision::PinholeCamera camera = camera_of(170, 170, 2 * std::atan(kTanX));
  Integrator integrator;
  const NextView next(viewer(), 0.05);
  for (const HeadAngles& d : next.directions()) {
    const Isometry3d pose = kChest * next.viewer().neck.chest_from_camera(d);
    integrator.integrate(all, look(room, camera, pose), pose, Time{});
  }
  const auto seen = [](const VoxelMap& map) { return explored(map).empty + explored(map).occupied; };
  EXPECT_GT(seen(chosen.map), 0.95 * seen(all));
  EXPECT_LT(2 * chosen.looked.size(), next.directions().size());
}

TEST(NextView, GivesUpOnWhatCannotBeSeen) {
  const Exploration blind(SyntheticRoom{}, true);
  EXPECT_GT(blind.looked.size(), 3U);
  EXPECT_LT(2 * blind.looked.size(), NextView(viewer(), 0.05).directions().size());
}

/// A free floor 5 m across, with a wall from y = -1 to the left end, and nothing known behind it.
struct BehindAWall {
  VoxelMap map;
  FloorMap floor;
  BehindAWall() : map(room_map(0.1)), floor(unseen_floor(floor_grid(map))) {
    const auto wall = map.index({1.05, 0, 0}).x(), end = map.index({0, -1, 0}).y();
    fill(map, {0, 0, 0}, map.size(), log_odds::kLowest);
    fill(map, {wall, end, 0}, {wall + 1, map.size().y(), map.size().z()}, log_odds::kHighest);
    fill(map, {wall + 1, end, 0}, map.size(), log_odds::kUnseen);
    for (int y = 0; y < floor.grid.height; ++y)
      for (int x = 0; x < floor.grid.width; ++x)
        floor.cells[floor.grid.index({x, y})] = y < end || x < wall ? Floor::kFree
                                                : x == wall         ? Floor::kBlocked
                                                                    : Floor::kUnseen;
  }
};

TEST(NextView, WalksToWhereItCanLookBehindAWall) {
  BehindAWall place;
  const Pose2 base{-0.5, -1, 0};
  const GaitLimits gait;
  Planner planner({}, gait, {}, place.floor.grid);
  NextView next(viewer(), 0.1);
  const auto turns = next.turns(place.map, base.lifted(1.0), {});
  const auto walks = next.walks(place.map, place.floor, planner, gait, base, 5);
  ASSERT_EQ(walks.size(), 5U);
  double best_turn = 0;
  for (const NextLook& look : turns) best_turn = std::max(best_turn, look.gain);
  EXPECT_GT(walks[0].gain, 2 * best_turn);
  for (std::size_t i = 0; i < walks.size(); ++i) {
    ASSERT_TRUE(walks[i].stance);
    EXPECT_EQ(place.floor.at(place.floor.grid.cell(walks[i].stance->position())), Floor::kFree);
    EXPECT_GT(walks[i].seconds, 0.5) << "to stay is no walk";
    EXPECT_GE(walks[i].seconds, gait.forward_seconds((walks[i].stance->position() - base.position()).norm()));
    EXPECT_LE(walks[i].rate(), walks[i > 0 ? i - 1 : 0].rate());
  }
}

TEST(NextView, WalksNowhereWithoutFreeFloor) {
  BehindAWall place;
  std::fill(place.floor.cells.begin(), place.floor.cells.end(), Floor::kUnseen);
  Planner planner({}, {}, {}, place.floor.grid);
  EXPECT_TRUE(NextView(viewer(), 0.1).walks(place.map, place.floor, planner, {}, {}, 5).empty());
}

TEST(NextView, RefusesAConfigurationThatCannotBe) {
  NextViewConfig config;
  config.least_gain = 0;
  EXPECT_THROW(NextView(viewer(), 0.05, config), InputError);
  config = {};
  config.look_seconds = 0;
  EXPECT_THROW(NextView(viewer(), 0.05, config), InputError);
  config = {};
  config.stance_spacing = std::nan("");
  EXPECT_THROW(NextView(viewer(), 0.05, config), InputError);
}

}  // namespace
}  // namespace headway::nav
