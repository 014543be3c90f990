// A walk that is longer than the map's window.
#include <cmath>

#include <gtest/gtest.h>

#include "hal/error.h"
#include "runtime/mapper.h"
#include "tests/runtime/flat_room.h"

namespace headway::runtime {
namespace {

constexpr double kWalk = 24, kWindow = 6, kStep = 0.3;

/// A hall of 28 m x 8 m, with the robot at its near end.
MapperConfig hall(double window) {
  MapperConfig config;
  config.voxels.resolution = 0.1;
  config.voxels.lowest = {-2, -4, -0.4};
  config.voxels.highest = {26, 4, 2.4};
  config.window = window;
  return config;
}

Boxes things() {
  Boxes boxes;
  for (double x = 1; x < kWalk; x += 1.7) boxes.push_back(box(x, x + 0.3, 0.5, 0.9, 0.6));
  return boxes;
}

/// What the robot sees of the floor around it from 2 m above.
void see(Mapper& mapper, double x) {
  const auto pose = from_above({x, 0}, 2);
  mapper.integrate(look(things(), pose), pose, Pose2{x, 0, 0}.lifted(1), at_seconds(x + 10));
  mapper.project();
}

void walk(Mapper& mapper, double from, double to) {
  const int steps = static_cast<int>(std::lround(std::abs(to - from) / kStep));
  for (int k = 0; k <= steps; ++k) see(mapper, from + (to - from) * k / steps);
}

/// The share of voxels that are something else in the other map.
double differing(const nav::ColdMap& map, const nav::ColdMap& other) {
  std::size_t all = 0, different = 0;
  map.for_any([&](const nav::BrickKey& key, const nav::BrickValues& values) {
    const nav::BrickValues* same = other.find(key);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const nav::LogOdds value = same == nullptr ? nav::log_odds::kUnseen : (*same)[i];
      different += nav::voxel_of(values[i]) != nav::voxel_of(value);
    }
    all += values.size();
  });
  return static_cast<double>(different) / static_cast<double>(all);
}

// Places are counted from the window's corner, so that a voxel on a limit may round to its other side.
TEST(MapperWindow, KnowsAfterALongWalkWhatAMapOfTheWholeHallKnows) {
  Mapper whole(hall(0), {}), windowed(hall(kWindow), {});
  for (Mapper* mapper : {&whole, &windowed}) walk(*mapper, 0, kWalk);
  EXPECT_LT(windowed.voxels().size().x() * 0.1, kWalk / 3);
  EXPECT_GT(windowed.aside().size(), 0U);
  EXPECT_EQ(whole.aside().size(), 0U);
  EXPECT_LE(differing(whole.everything(), windowed.everything()), 1e-3);
  EXPECT_LE(differing(windowed.everything(), whole.everything()), 1e-3);

  const nav::FloorMap &a = windowed.floor(), &b = whole.floor();
  ASSERT_EQ(a.grid, b.grid);
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.seen_at, b.seen_at);
}

TEST(MapperWindow, HasAtHandAgainWhatTheRobotComesBackTo) {
  Mapper mapper(hall(kWindow), {});
  walk(mapper, 0, kWalk);
  const Eigen::Vector3d on_box(1.15, 0.65, 0.55);
  ASSERT_FALSE(mapper.voxels().contains(mapper.voxels().index(on_box)));
  const nav::ColdMap before = mapper.everything();
  const vision::RangeView nothing = look({}, from_above({0, 0}, 2), true);
  for (double x = kWalk; x > 0; x -= kStep)
    mapper.integrate(nothing, from_above({x, 0}, 2), Pose2{x, 0, 0}.lifted(1), at_seconds(100));
  EXPECT_EQ(mapper.voxels().at_point(on_box), nav::Voxel::kOccupied);
  EXPECT_TRUE(mapper.everything() == before);
}

TEST(MapperWindow, KeepsTheMemoryAtHandTheSameAndAsideWhatWasSeen) {
  Mapper mapper(hall(kWindow), {});
  const std::size_t at_hand = mapper.voxels().bytes();
  walk(mapper, 0, kWalk / 2);
  const std::size_t half_way = mapper.aside().size();
  walk(mapper, kWalk / 2, kWalk);
  EXPECT_EQ(mapper.voxels().bytes(), at_hand);
  EXPECT_LT(at_hand, Mapper(hall(0), {}).voxels().bytes() / 2);
  const std::size_t all = mapper.aside().size();
  EXPECT_GT(all, half_way);
  walk(mapper, kWalk, 0);
  walk(mapper, 0, kWalk);
  EXPECT_EQ(mapper.aside().size(), all) << "nothing new was seen";
}

TEST(MapperWindow, TakesOverAMapThatIsKnownFromBefore) {
  Mapper before(hall(kWindow), {});
  walk(before, 0, kWalk);
  for (const double window : {kWindow, 0.0}) {
    Mapper now(hall(window), {});
    now.restore(before.everything());
    EXPECT_TRUE(now.everything() == before.everything());
    EXPECT_EQ(now.voxels().first_key(), Mapper(hall(window), {}).voxels().first_key());
    EXPECT_EQ(now.floor().cells, before.floor().cells);
    EXPECT_EQ(now.floor().seen(now.floor().grid.cell({9, 0.1})), nav::kNever) << "not in this life";
    see(now, 0.3);
    EXPECT_EQ(now.voxels().at_point({1.15, 0.65, 0.55}), nav::Voxel::kOccupied);
  }
}

TEST(MapperWindow, RefusesAMapWithOtherVoxels) {
  Mapper mapper(hall(kWindow), {});
  EXPECT_THROW(mapper.restore(nav::ColdMap(0.05)), InputError);
}

TEST(MapperWindow, StaysWhileTheRobotSways) {
  Mapper mapper(hall(kWindow), {});
  walk(mapper, 0, 9);
  const Eigen::Vector3i first = mapper.voxels().first_key();
  for (int k = 0; k < 20; ++k) see(mapper, 9 + (k % 2 == 0 ? 0.1 : -0.1));
  EXPECT_EQ(mapper.voxels().first_key(), first);
}

TEST(MapperWindow, CoversTheWholeBoxWhenItIsWider) {
  Mapper mapper(hall(100), {}), whole(hall(0), {});
  EXPECT_EQ(mapper.voxels().size(), whole.voxels().size());
  walk(mapper, 0, 5);
  EXPECT_EQ(mapper.voxels().first_key(), whole.voxels().first_key());
}

}  // namespace
}  // namespace headway::runtime
