// Things that stand about for a while and then leave, and walls that stay whatever the camera errs.
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "map_score.h"
#include "nav/floor_map.h"
#include "nav/integrate.h"
#include "room_map.h"
#include "synthetic_room.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

constexpr double kSigma = 0.15;  // [px]
// [m] What stands lower may lie within three sigma of the floor behind it: not every frame sees through it.
constexpr double kClearOfFloor = 0.2;

/// A robot that looks at one place of a room.
struct Watcher {
  Isometry3d pose = camera_pose({-2, 0, 1.4}, 0, 32 * kDegree);
  vision::PinholeCamera camera = camera_of(170, 240, 40 * kDegree);
  Noise noise{.disparity_sigma = kSigma, .correlation = 2, .outliers = 0.005, .seed = 1};
  VoxelMap map = room_map();
  Integrator integrator{};
  int frames = 0;

  void watch(const SyntheticRoom& room, int times) {
    for (int k = 0; k < times; ++k) {
      ++noise.seed;
      integrator.integrate(map, look(room, camera, pose, noise, kSigma), pose, at_seconds(++frames));
    }
  }
};

/// How many voxels count as occupied between two corners [m].
int occupied(const VoxelMap& map, const SolidBox& box) {
  int count = 0;
  for_each_known(map, [&](const VoxelMap::Index& i) {
    const Vector3d p = map.centre(i);
    count += map.at(i) == Voxel::kOccupied && (p.array() >= box.lowest.array()).all() &&
             (p.array() <= box.highest.array()).all();
  });
  return count;
}

int blocked(const FloorMap& floor, const SolidBox& box) {
  int count = 0;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      const Eigen::Vector2d p = floor.grid.centre({x, y});
      count += floor.at({x, y}) == Floor::kBlocked && p.x() >= box.lowest.x() && p.y() >= box.lowest.y() &&
               p.x() <= box.highest.x() && p.y() <= box.highest.y();
    }
  }
  return count;
}

/// On the floor, in view.
SolidBox any_thing() {
  const auto between = [](int lowest, int highest) { return 0.01 * *rc::gen::inRange(lowest, highest + 1); };
  const double x = between(-50, 60), y = between(-30, 10);
  return {{x, y, 0}, {x + between(10, 50), y + between(10, 40), between(35, 90)}};
}

/// Twenty looks at it, and the box that its voxels lie in, apart from those near the floor.
SolidBox watch_thing(const SolidBox& thing, Watcher& watcher) {
  SyntheticRoom with;
  with.solids = {thing};
  watcher.watch(with, 20);
  const double edge = watcher.map.resolution();
  return {thing.lowest - Vector3d(2 * edge, 2 * edge, -kClearOfFloor),
          thing.highest + Vector3d::Constant(2 * edge)};
}

// A pixel that is matched wrongly does not see the place; without those, three frames do.
RC_GTEST_PROP(MovingThings, AreGoneWithinThreeFramesThatSeeTheirPlaceAndNotAfterOne, ()) {
  const SolidBox thing = any_thing();
  Watcher watcher;
  watcher.noise.seed = *rc::gen::inRange<std::uint64_t>(1, 1000000);
  const SolidBox place = watch_thing(thing, watcher);
  const SolidBox core{{thing.lowest.x(), thing.lowest.y(), place.lowest.z()}, thing.highest};
  const int before = occupied(watcher.map, core);
  RC_ASSERT(before > 3);
  watcher.noise.outliers = 0;
  watcher.watch(SyntheticRoom{}, 1);
  RC_ASSERT(occupied(watcher.map, core) == before);
  watcher.watch(SyntheticRoom{}, 2);
  RC_ASSERT(occupied(watcher.map, place) == 0);
}

// Where a pixel was wrong, one of the three frames did not see the place.
TEST(MovingThings, BlockNoFloorAfterThreeFramesExceptWhereAPixelWasWrong) {
  int before = 0, after = 0;
  rc::check([&] {
    const SolidBox thing = any_thing();
    Watcher watcher;
    watcher.noise.seed = *rc::gen::inRange<std::uint64_t>(1, 1000000);
    watch_thing(thing, watcher);
    const SolidBox place{thing.lowest - Vector3d::Constant(0.1), thing.highest + Vector3d::Constant(0.1)};
    const int blocked_before = blocked(floor_map(watcher.map), place);
    RC_ASSERT(blocked_before > 2);
    watcher.watch(SyntheticRoom{}, 3);
    const int blocked_after = blocked(floor_map(watcher.map), place);
    RC_ASSERT(blocked_after <= 4);
    before += blocked_before;
    after += blocked_after;
  });
  EXPECT_LT(after, 0.002 * before);
}

// Twenty passes; half of the looks go along a wall at a grazing angle.
TEST(StandingThings, StayUnderNoiseAndOutliersHoweverOftenTheyAreSeen) {
  const auto room = SyntheticRoom::furnished();
  Watcher watcher;
  watcher.noise.outliers = 0.01;
  std::vector<Isometry3d> poses;
  for (double yaw = -1.6; yaw < 1.7; yaw += 0.4) {
    poses.push_back(camera_pose({-1.2, 0.1, 1.37}, yaw, 0.3));
    poses.push_back(camera_pose({-1.2 + 0.5 * yaw, -2.2, 1.2}, 0.15 * yaw, 0.1));
  }
  for (int pass = 0; pass < 20; ++pass) {
    for (const Isometry3d& pose : poses) {
      watcher.pose = pose;
      watcher.watch(room, 1);
    }
  }
  const MapScore s = score(watcher.map, room, watcher.camera, poses);
  EXPECT_GE(s.surface_occupied, 0.985);
  EXPECT_LE(s.surface_emptied, 0.001);
  EXPECT_EQ(s.solid_emptied, 0);
  EXPECT_EQ(s.pole_occupied, 1);
}

}  // namespace
}  // namespace headway::nav
