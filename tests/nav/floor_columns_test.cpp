#include "nav/floor_columns.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "any_cold_map.h"
#include "hal/error.h"

namespace headway::nav {
namespace {

FloorMap any_floor() {
  const double resolution = *rc::gen::element(0.02, 0.05, 0.1, 0.2, 1.0);
  FloorMap floor =
      unseen_floor({resolution,
                    {*rc::gen::inRange(-90, 90) * resolution, *rc::gen::inRange(-90, 90) * resolution},
                    *rc::gen::inRange(1, 30),
                    *rc::gen::inRange(1, 30)});
  for (auto& cell : floor.cells) cell = *rc::gen::element(Floor::kUnseen, Floor::kFree, Floor::kBlocked);
  floor.cells.front() = Floor::kFree;
  return floor;
}

RC_GTEST_PROP(FloorColumns, AreTheFloorTheyWereRaisedFrom, ()) {
  const FloorMap floor = any_floor();
  const FloorMap again = floor_below(raise_floor(floor, 1.7));
  RC_ASSERT(again.grid.resolution == floor.grid.resolution);
  std::size_t known = 0, known_again = 0;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      known += floor.at({x, y}) != Floor::kUnseen;
      RC_ASSERT(again.at(again.grid.cell(floor.grid.centre({x, y}))) == floor.at({x, y}));
    }
  }
  for (const Floor cell : again.cells) known_again += cell != Floor::kUnseen;
  RC_ASSERT(known == known_again);
}

RC_GTEST_PROP(FloorColumns, AreFoundWhereverTheFloorLies, ()) {
  const FloorMap floor = any_floor();
  const ColdMap map = raise_floor(floor, 1.7);
  const std::int32_t lift = *rc::gen::inRange(-40, 40);  // bricks
  ColdMap lifted(map.resolution());
  map.for_any([&](const BrickKey& key, const BrickValues& values) {
    lifted.put({key.x, key.y, key.z + lift}, values);
  });
  const FloorMap below = floor_below(map),
                 again = floor_below(lifted, {}, lift * kBrickEdge * map.resolution());
  RC_ASSERT(again.grid == below.grid);
  RC_ASSERT(again.cells == below.cells);
}

TEST(FloorColumns, GoToTheNearestColumnsOfVoxels) {
  FloorMap floor = unseen_floor({0.1, {0.04, -0.06}, 1, 1});
  floor.cells = {Floor::kBlocked};
  const ColdMap map = raise_floor(floor, 0.5);
  ASSERT_NE(map.find({0, -1, 0}), nullptr);
  EXPECT_EQ((*map.find({0, -1, 0}))[static_cast<std::size_t>(in_brick(0, 7, 4))], log_odds::kHighest);
  EXPECT_EQ((*map.find({0, -1, 0}))[static_cast<std::size_t>(in_brick(0, 7, 5))], log_odds::kUnseen);
}

template <class Work>
std::string complaint(Work work) {
  try {
    work();
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(FloorColumns, SayWhatIsWrong) {
  using testing::HasSubstr;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  FloorMap floor = unseen_floor({0.1, {0, 0}, 100, 100});
  for (Floor& cell : floor.cells) cell = Floor::kFree;
  EXPECT_THAT(complaint([&] { raise_floor(floor, kNan); }), HasSubstr("height: nan m"));
  EXPECT_THAT(complaint([&] { raise_floor(floor, 0); }), HasSubstr("expected at least a voxel"));
  EXPECT_THAT(complaint([&] { raise_floor(floor, 1.7, 100); }), HasSubstr("more than 100 bricks"));
  EXPECT_THAT(complaint([&] { floor_below(ColdMap(0.1)); }), HasSubstr("nothing was seen between"));
  EXPECT_THAT(complaint([&] { floor_below(raise_floor(floor, 1), {}, 50); }), HasSubstr("nothing was seen"));
  EXPECT_THAT(complaint([&] { floor_below(ColdMap(0.1), {}, kNan); }), HasSubstr("lies outside of the map"));
  floor.grid.origin.x() = 5000;
  EXPECT_THAT(complaint([&] { raise_floor(floor, 1); }), HasSubstr("beyond 3276.8 m"));
  ColdMap far_apart(0.1);
  BrickValues values;
  values.fill(5);
  far_apart.put({-4000, 0, 0}, values);
  far_apart.put({4000, 4000, 0}, values);
  EXPECT_THAT(complaint([&] { floor_below(far_apart); }), HasSubstr("more than 3e8 voxels"));
}

}  // namespace
}  // namespace headway::nav
