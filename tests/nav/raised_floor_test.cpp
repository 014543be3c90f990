#include "nav/raised_floor.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/nav/synthetic_room.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d;

constexpr double kEye = 1.4;  // of the camera above the floor [m]

FloorGrid grid() { return {0.05, {-1, -2}, 80, 80}; }

/// A floor with a box on it, as high as is said.
SyntheticRoom floor_with(const Vector2d& low, const Vector2d& high, double height) {
  SyntheticRoom room;
  room.solids = {{{low.x(), low.y(), 0}, {high.x(), high.y(), height}}};
  return room;
}

/// Views from the origin, down to the floor 1.2 m ahead, with a stereo camera's noise.
void look_down(RaisedFloor& raised, const SyntheticRoom& room, int views, double tilt_error = 0) {
  for (int k = 0; k < views; ++k) {
    const Noise noise{
        .disparity_sigma = 0.15, .correlation = 2, .outliers = 0.01, .seed = static_cast<std::uint64_t>(k)};
    const Eigen::Isometry3d pose = camera_pose({0, 0, kEye}, 0, 0.85);
    const Eigen::Isometry3d believed = camera_pose({0, 0, kEye}, 0, 0.85 + tilt_error);
    raised.add(look(room, camera_of(640, 480, 0.9), pose, noise, 0.15), believed);
  }
}

/// Shares of the cells of which something is so, in the middle of a box and where the floor is level.
struct Shares {
  double box = 0, level = 0;
};
template <class IsSo>
Shares shares_of(const Vector2d& low, const Vector2d& high, const IsSo& is_so) {
  int on = 0, on_so = 0, off = 0, off_so = 0;
  const FloorGrid g = grid();
  for (int y = 0; y < g.height; ++y) {
    for (int x = 0; x < g.width; ++x) {
      const Vector2d c = g.centre({x, y});
      if (c.x() < 0.7 || c.x() > 1.9 || std::abs(c.y()) > 0.4) continue;
      const Vector2d out = (low - c).cwiseMax(c - high);
      if (out.maxCoeff() < -0.02) ++on, on_so += is_so(Eigen::Vector2i(x, y));
      if (out.maxCoeff() > 0.05) ++off, off_so += is_so(Eigen::Vector2i(x, y));
    }
  }
  return {on_so / std::max(1.0, double(on)), off_so / std::max(1.0, double(off))};
}
Shares shares(const RaisedFloor& raised, const Vector2d& low, const Vector2d& high) {
  return shares_of(low, high, [&](const Eigen::Vector2i& cell) { return raised.raised(cell); });
}
Shares low_shares(const RaisedFloor& raised, const Vector2d& low, const Vector2d& high) {
  return shares_of(low, high, [&](const Eigen::Vector2i& cell) { return raised.low(cell); });
}
Shares level_shares(const RaisedFloor& raised, const Vector2d& low, const Vector2d& high) {
  return shares_of(low, high, [&](const Eigen::Vector2i& cell) { return raised.level(cell); });
}

RC_GTEST_PROP(RaisedFloor, IsWhatRisesMoreThanTheTripHeightWhereverItLies, ()) {
  const double x = *rc::gen::inRange(90, 140) / 100.0, height = *rc::gen::inRange(0, 12) / 100.0;
  const Vector2d low(x, -0.3), high(x + *rc::gen::inRange(10, 40) / 100.0, 0.3);
  RaisedFloor raised(grid());
  look_down(raised, floor_with(low, high, height), 4);
  const Shares found = shares(raised, low, high);
  if (height >= 0.04) RC_ASSERT(found.box > 0.9);
  if (height <= 0.01) RC_ASSERT(found.box == 0);
  RC_ASSERT(found.level < 0.005);
}

TEST(RaisedFloor, IsNoneWhereTheHeadErrsByATenthOfADegree) {
  RaisedFloor raised(grid());
  for (const double error : {-0.0017, 0.0017}) {
    look_down(raised, floor_with({5, 5}, {6, 6}, 1), 6, error);
    EXPECT_EQ(shares(raised, {5, 5}, {6, 6}).level, 0);
  }
}

TEST(RaisedFloor, NeedsTwoViewsAndForgetsWhatIsGoneAfterTwo) {
  const Vector2d low(1, -0.2), high(1.2, 0.2);
  RaisedFloor raised(grid());
  look_down(raised, floor_with(low, high, 0.06), 1);
  EXPECT_EQ(shares(raised, low, high).box, 0);
  EXPECT_TRUE(raised.changed().empty());
  look_down(raised, floor_with(low, high, 0.06), 4);
  EXPECT_GT(shares(raised, low, high).box, 0.9);
  look_down(raised, floor_with(low, high, 0), 2);
  EXPECT_EQ(shares(raised, low, high).box, 0);
  EXPECT_FALSE(raised.changed().empty());
}

TEST(RaisedFloor, IsNotLookedForWhereTheTripHeightIsNought) {
  RaisedFloorConfig config;
  config.trip_height = 0;
  RaisedFloor raised(grid(), config);
  look_down(raised, floor_with({1, -0.2}, {1.2, 0.2}, 0.08), 4);
  EXPECT_EQ(shares(raised, {1, -0.2}, {1.2, 0.2}).box, 0);
}

RC_GTEST_PROP(RaisedFloor, IsLowWhereWhatRisesIsNoHigherThanSoAndLevelWhereNothingRises, ()) {
  RaisedFloorConfig config;
  config.low_height = 0.06;
  const double x = *rc::gen::inRange(90, 140) / 100.0, height = *rc::gen::inRange(0, 14) / 100.0;
  const Vector2d low(x, -0.3), high(x + *rc::gen::inRange(10, 40) / 100.0, 0.3);
  RaisedFloor raised(grid(), config);
  look_down(raised, floor_with(low, high, height), 4);
  const Shares found_low = low_shares(raised, low, high), level = level_shares(raised, low, high);
  if (height >= 0.04 && height <= 0.05) RC_ASSERT(found_low.box > 0.9);
  if (height >= 0.09 || height <= 0.01) RC_ASSERT(found_low.box == 0);
  if (height >= 0.04) RC_ASSERT(level.box == 0);
  if (height == 0) RC_ASSERT(level.box > 0.95);
  RC_ASSERT(level.level > 0.8);
  for (int i = 0; i < grid().width * grid().height; ++i) {
    const Eigen::Vector2i cell(i % grid().width, i / grid().width);
    RC_ASSERT(raised.raised(cell) || !raised.low(cell));
    RC_ASSERT(!raised.raised(cell) || !raised.level(cell));
  }
}

TEST(RaisedFloor, IsNoLongerLowOnceAViewShowsThatItIsHigher) {
  const Vector2d low(1, -0.2), high(1.2, 0.2);
  RaisedFloorConfig config;
  config.low_height = 0.06;
  RaisedFloor raised(grid(), config);
  look_down(raised, floor_with(low, high, 0.05), 4);
  EXPECT_GT(low_shares(raised, low, high).box, 0.9);
  look_down(raised, floor_with(low, high, 0.1), 1);
  EXPECT_EQ(low_shares(raised, low, high).box, 0);
  EXPECT_GT(shares(raised, low, high).box, 0.9);
  EXPECT_FALSE(raised.changed().empty());
}

TEST(RaisedFloor, IsNeverLowWhereNothingCountsAsSo) {
  for (const double height : {0.04, 0.05, 0.06}) {
    RaisedFloor raised(grid());
    look_down(raised, floor_with({1, -0.2}, {1.2, 0.2}, height), 4);
    EXPECT_GT(shares(raised, {1, -0.2}, {1.2, 0.2}).box, 0.9);
    EXPECT_EQ(low_shares(raised, {1, -0.2}, {1.2, 0.2}).box, 0) << height;
  }
}

TEST(RaisedFloor, RefusesAConfigurationThatCannotBe) {
  RaisedFloorConfig config;
  config.trip_height = -0.01;
  EXPECT_THROW(RaisedFloor(grid(), config), InputError);
  config = {};
  config.highest = 0.01;
  EXPECT_THROW(RaisedFloor(grid(), config), InputError);
  config = {};
  config.low_height = config.highest + 0.01;
  EXPECT_THROW(RaisedFloor(grid(), config), InputError);
}

}  // namespace
}  // namespace headway::nav
