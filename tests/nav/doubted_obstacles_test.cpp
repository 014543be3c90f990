// What came may have gone until it is seen standing there; what always stood there has not.
#include "nav/doubted_obstacles.h"

#include <gtest/gtest.h>

#include "tests/nav/random_floor.h"

namespace headway::nav {
namespace {

using Eigen::Vector2i;

/// A floor that was free but for a wall and the place a box came from; then the box came.
struct Scene {
  FloorMap floor = free_floor(60, 40, 0.05);
  PassingObstacles passing{floor.grid, {}};
  DoubtedObstacles doubted{floor.grid};

  Scene() {
    fill(floor, {0, 30}, {59, 32}, Floor::kBlocked);
    fill(floor, {20, 10}, {25, 15}, Floor::kBlocked);
    passing.see(floor);
    fill(floor, {26, 10}, {33, 15}, Floor::kBlocked);
    passing.see(floor);
  }
  FloorMap hoped() const {
    FloorMap hoped;
    doubted.hope(floor, passing, hoped);
    return hoped;
  }
  /// How many cells of a box are unseen on the hoped floor.
  int made_way(const Vector2i& low, const Vector2i& high) const {
    const FloorMap hoped = this->hoped();
    int cells = 0;
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) cells += hoped.at({x, y}) == Floor::kUnseen;
    return cells;
  }
  /// Shows obstacles on one cell.
  void stands(const Vector2i& cell, Time stamp) {
    vision::RangeView view;
    view.camera = {20, 20, 400, 9.5, 9.5};
    view.near = 0.3;
    view.far = 6;
    view.depth.assign(400, 0.4F);
    view.sigma_depth.assign(400, 0.002F);
    Eigen::Isometry3d from_above = Eigen::Isometry3d::Identity();
    from_above.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    from_above.translation() << floor.grid.centre(cell), 1.0;
    passing.look(view, from_above, stamp);
  }
};

TEST(DoubtedObstacles, AreWhatCameAndThePlaceThatItCameFrom) {
  Scene scene;
  EXPECT_EQ(scene.hoped().cells, scene.floor.cells);
  scene.doubted.doubt(scene.floor, scene.passing, at_seconds(1));
  EXPECT_EQ(scene.made_way({20, 10}, {33, 15}), 14 * 6) << "all of it";
  EXPECT_EQ(scene.made_way({0, 0}, {59, 39}), 14 * 6) << "and nothing else";
  EXPECT_EQ(scene.hoped().seen_at, scene.floor.seen_at);
}

TEST(DoubtedObstacles, AreNotWhatNoiseMakesOfTheBordersOfAWall) {
  Scene scene;
  fill(scene.floor, {0, 28}, {59, 29}, Floor::kBlocked);
  scene.doubted.doubt(scene.floor, scene.passing, at_seconds(1));
  EXPECT_EQ(scene.made_way({0, 28}, {59, 32}), 0);
}

TEST(DoubtedObstacles, AreSpecksButNothingLargerThatAlwaysStoodThere) {
  Scene scene;
  fill(scene.floor, {45, 5}, {46, 6}, Floor::kBlocked);
  fill(scene.floor, {50, 5}, {54, 5}, Floor::kBlocked);
  scene.doubted.doubt(scene.floor, scene.passing, at_seconds(1));
  EXPECT_EQ(scene.made_way({45, 5}, {46, 6}), 4);
  EXPECT_EQ(scene.made_way({50, 5}, {54, 5}), 0);
  scene.stands({45, 5}, at_seconds(2));
  EXPECT_EQ(scene.hoped().at({45, 5}), Floor::kBlocked);
}

TEST(DoubtedObstacles, ReachNoFartherThanThingsThatMove) {
  Scene scene;
  fill(scene.floor, {5, 25}, {9, 29}, Floor::kBlocked);  // came before the wall
  scene.doubted.doubt(scene.floor, scene.passing, at_seconds(1));
  EXPECT_GT(scene.made_way({0, 30}, {59, 32}), 20);
  EXPECT_EQ(scene.made_way({22, 30}, {59, 32}), 0);
}

TEST(DoubtedObstacles, AreBelievedWhereTheyAreSeenStanding) {
  Scene scene;
  scene.stands({22, 12}, at_seconds(1));
  scene.doubted.doubt(scene.floor, scene.passing, at_seconds(2));
  EXPECT_EQ(scene.hoped().at({22, 12}), Floor::kUnseen) << "that was before";
  scene.stands({30, 12}, at_seconds(3));
  EXPECT_EQ(scene.hoped().at({30, 12}), Floor::kBlocked);
  EXPECT_EQ(scene.hoped().at({22, 12}), Floor::kUnseen);
  scene.doubted.believe(scene.floor, scene.passing);
  EXPECT_EQ(scene.hoped().cells, scene.floor.cells) << "nothing is doubted any more";
  scene.doubted.doubt(scene.floor, scene.passing, at_seconds(9));
  EXPECT_EQ(scene.hoped().at({30, 12}), Floor::kBlocked) << "for good";
  EXPECT_EQ(scene.hoped().at({22, 12}), Floor::kUnseen);
  scene.doubted.see(free_floor(60, 40, 0.05));
  scene.doubted.doubt(scene.floor, scene.passing, at_seconds(9));
  EXPECT_EQ(scene.hoped().at({30, 12}), Floor::kUnseen) << "it went, and another one came";
}

}  // namespace
}  // namespace headway::nav
