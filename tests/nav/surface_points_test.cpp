#include "nav/surface_points.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "known_room.h"

namespace headway::nav {
namespace {

using Eigen::Vector3d;

const Vector3d kEye(0, 0, 1.4);

SyntheticRoom wall_at(double x) {
  SyntheticRoom room;
  room.walls = {{-50, -50, 0}, {x, 50, 20}};
  return room;
}

TEST(SurfacePoints, KnowAWallToAFractionOfAVoxelWhereverItStands) {
  std::mt19937_64 random(1);
  for (std::uint64_t i = 0; i < 20; ++i) {
    const double x = 1.5 + uniform(random);
    KnownRoom known(wall_at(x));
    for (std::uint64_t view = 0; view < 3; ++view) known.learn(camera_pose(kEye, 0, 0.1), 10 * i + view);
    const auto plane = known.surfaces.plane(known.map.index({x - 1e-9, 0.1, 1.2}), known.map);
    ASSERT_TRUE(plane) << x;
    EXPECT_NEAR(plane->point.x(), x, 0.004);
    EXPECT_GT(std::abs(plane->normal.x()), std::cos(0.05));
    EXPECT_LT(std::abs(plane->point.x() - x), 4 * (plane->sigma + 0.001)) << x;
  }
}

TEST(SurfacePoints, KnowTheNormalsOfBlocksBetterThanThoseOfVoxels) {
  double of_blocks = 0, of_voxels = 0, in_sigmas = 0;
  int blocks = 0, voxels = 0;
  for (std::uint64_t i = 0; i < 10; ++i) {
    KnownRoom known(wall_at(3.3 + 0.02 * static_cast<double>(i)));
    for (std::uint64_t view = 0; view < 3; ++view) known.learn(camera_pose(kEye, 0, 0.1), 10 * i + view);
    for (double y = -0.5; y < 0.5; y += 0.2) {
      const VoxelMap::Index at = known.map.index({known.room.walls.highest.x() - 1e-9, y, 1.2});
      const auto off = [](const SurfacePlane& plane) { return std::acos(std::abs(plane.normal.x())); };
      if (const auto plane = known.surfaces.plane(at, known.map)) {
        of_voxels += off(*plane) * off(*plane);
        ++voxels;
      }
      const auto plane =
          known.surfaces.block_plane(SurfacePoints::block_of(at + known.map.first_key()), known.map);
      if (!plane) continue;
      of_blocks += off(*plane) * off(*plane);
      in_sigmas += off(*plane) * off(*plane) / plane->tilt.trace();
      ++blocks;
    }
  }
  ASSERT_GE(blocks, 40);
  ASSERT_GE(voxels, 5);
  EXPECT_LT(std::sqrt(of_blocks / blocks), 0.6 * std::sqrt(of_voxels / voxels));
  EXPECT_LT(std::sqrt(in_sigmas / blocks), 1.5) << "or it is surer than it can be";
  EXPECT_GT(std::sqrt(in_sigmas / blocks), 0.5) << "or less sure than it need be";
}

// Noise spreads the points of a wall over voxels on both sides of the faces of blocks: a mean over those on
// one side would be off by most of the noise.
TEST(SurfacePoints, AreNotCutWhereABlockEnds) {
  for (int i = 0; i < 21; ++i) {
    const double x = 2.9 + 0.01 * i;  // a block ends at 3
    KnownRoom known(wall_at(x));
    for (std::uint64_t view = 0; view < 4; ++view) known.learn(camera_pose(kEye, 0, 0.1), view);
    int planes = 0;
    for (double y = -0.5; y < 0.5; y += 0.2)
      for (const double beside : {-0.03, 0.03}) {
        const VoxelMap::Index at = known.map.index({x + beside, y, 1.2});
        const auto plane =
            known.surfaces.block_plane(SurfacePoints::block_of(at + known.map.first_key()), known.map);
        if (!plane) continue;
        EXPECT_NEAR(plane->point.x(), x, 0.005);
        ++planes;
      }
    ASSERT_GE(planes, 4) << x;
  }
}

TEST(SurfacePoints, FaceTheSideThatTheyWereSeenFrom) {
  for (const double x : {1.9, 1.93, 1.97, 2.0})
    for (const bool from_behind : {false, true}) {
      SyntheticRoom room = wall_at(4.2);
      room.solids = {{{x, -3, 0}, {x + 0.1, 3, 3}}};
      KnownRoom known(room);
      const Vector3d eye(from_behind ? 4 : 0, 0, 1.4);
      for (std::uint64_t view = 0; view < 4; ++view)
        known.learn(camera_pose(eye, from_behind ? std::numbers::pi : 0, 0.1), view);
      const VoxelMap::Index at = known.map.index({from_behind ? x + 0.1 + 1e-9 : x - 1e-9, 0.1, 1.2});
      const auto block = SurfacePoints::block_of(at + known.map.first_key());
      for (const auto& plane :
           {known.surfaces.plane(at, known.map), known.surfaces.block_plane(block, known.map)}) {
        ASSERT_TRUE(plane) << x;
        EXPECT_TRUE(plane->sided) << x;
        EXPECT_GT(from_behind ? plane->normal.x() : -plane->normal.x(), 0.9) << x;
      }
      const auto old = without_rays(known.surfaces).block_plane(block, known.map);
      ASSERT_TRUE(old) << x;
      EXPECT_FALSE(old->sided) << "the rays are not known";
    }
}

TEST(SurfacePoints, SayNothingOfAThingSoThinThatBothFacesAreOne) {
  SyntheticRoom room = wall_at(4.2);
  room.solids = {{{2.0, -3, 0}, {2.02, 3, 3}}};
  KnownRoom known(room);
  for (std::uint64_t view = 0; view < 4; ++view) known.learn(camera_pose(kEye, 0, 0.1), view);
  const VoxelMap::Index at = known.map.index({2.01, 0.1, 1.2});
  const auto block = SurfacePoints::block_of(at + known.map.first_key());
  ASSERT_TRUE(known.surfaces.block_plane(block, known.map)) << "while one side alone was seen";
  for (std::uint64_t view = 0; view < 4; ++view)
    known.learn(camera_pose({4.0, 0, 1.4}, std::numbers::pi, 0.1), 10 + view);
  EXPECT_FALSE(known.surfaces.block_plane(block, known.map));
  EXPECT_FALSE(known.surfaces.plane(at, known.map));
}

TEST(SurfacePoints, TakeNoBlockForAPlaneThatHoldsAnEdge) {
  SyntheticRoom room;
  room.walls = {{-2.7, -2.5, 0}, {50, 50, 20}};  // the corner stands in the middle of a block
  KnownRoom known(room);
  known.look_around(kEye, 0);
  const auto block_plane = [&](const Vector3d& at) {
    return known.surfaces.block_plane(SurfacePoints::block_of(known.map.index(at) + known.map.first_key()),
                                      known.map);
  };
  EXPECT_TRUE(block_plane({-2.69, -2.3, 1.3}));
  EXPECT_TRUE(block_plane({-2.5, -2.49, 1.3}));
  EXPECT_FALSE(block_plane({-2.69, -2.49, 1.3}));
}

TEST(SurfacePoints, SayNothingAtEdgesAndInTheAir) {
  KnownRoom known(SyntheticRoom::furnished());
  known.look_around(kEye, 0);
  const SolidBox& crate = known.room.solids[3];
  const Vector3d corner(crate.lowest.x(), crate.highest.y(), crate.highest.z());
  EXPECT_FALSE(known.surfaces.plane(known.map.index(corner), known.map));
  EXPECT_FALSE(known.surfaces.plane(known.map.index({0.5, 0, 1.4}), known.map));
}

TEST(SurfacePoints, ForgetAWallThatTheMapHasEmptied) {
  KnownRoom known(wall_at(2.02));
  known.learn(camera_pose(kEye, 0, 0.1), 1);
  const VoxelMap::Index there = known.map.index({2.02, 0.1, 1.2});
  ASSERT_TRUE(known.surfaces.plane(there, known.map));
  known.room = wall_at(3.02);
  for (std::uint64_t i = 0; i < 8; ++i) known.learn(camera_pose(kEye, 0, 0.1), 2 + i);
  EXPECT_FALSE(known.surfaces.plane(there, known.map));
  EXPECT_TRUE(known.surfaces.plane(known.map.index({3.02, 0.1, 1.2}), known.map));
}

TEST(SurfacePoints, StayWhereTheFirstLooksPutThem) {
  KnownRoom known(wall_at(2.01));
  for (std::uint64_t i = 0; i < 4; ++i) known.learn(camera_pose(kEye, 0, 0.1), i);
  const VoxelMap::Index there = known.map.index({2.01, 0.1, 1.2});
  const auto before = known.surfaces.plane(there, known.map);
  known.room = wall_at(2.03);  // as if the robot were two centimetres off
  for (std::uint64_t i = 0; i < 50; ++i)
    known.learn(camera_pose(kEye, 0, 0.1), 100 + i, {.shift = 0.02 * 0.02, .turn = 1e-4});
  const auto after = known.surfaces.plane(there, known.map);
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(after->point.x(), before->point.x(), 0.002);
}

TEST(SurfacePoints, GiveWayToALookFromAPoseThatIsKnownBetter) {
  KnownRoom known(wall_at(2.01));
  const VoxelMap::Index there = known.map.index({2.01, 0.1, 1.2});
  for (std::uint64_t i = 0; i < 20; ++i)
    known.learn(camera_pose(kEye, 0, 0.1), i, {.shift = 0.02 * 0.02, .turn = 1e-4});
  const auto before = known.surfaces.plane(there, known.map);
  known.room = wall_at(2.03);
  for (std::uint64_t i = 0; i < 3; ++i) known.learn(camera_pose(kEye, 0, 0.1), 100 + i);
  const auto after = known.surfaces.plane(there, known.map);
  ASSERT_TRUE(before && after);
  EXPECT_GT(before->doubt, 0.015 * 0.015);
  EXPECT_LT(after->doubt, 0.1 * before->doubt);
  EXPECT_NEAR(after->point.x(), 2.03, 0.004);
}

// However often a matcher looks from afar, its error stays: near looks tell the place.
TEST(SurfacePoints, GiveWayToANearerLookOfAMatcher) {
  KnownRoom known(wall_at(3.01));
  const auto learn = [&](double from, double wall, std::uint64_t seed) {
    const Eigen::Isometry3d pose = camera_pose({from, 0, 1.4}, 0, 0.1);
    known.room = wall_at(wall);
    vision::RangeView view = known.see(pose, seed);
    view.weight.assign(view.depth.size(), 1.0F);
    known.integrator.integrate(known.map, view, pose, Time{});
    view_patches(view, {}, known.patches);
    known.surfaces.add(known.patches, pose, known.map);
  };
  for (std::uint64_t i = 0; i < 20; ++i) learn(-1.9, 3.04, i);  // as a matcher might have it
  const auto plane = [&] {
    const VoxelMap::Index there = known.map.index({3.03, 0.1, 1.3}) + known.map.first_key();
    return known.surfaces.block_plane(SurfacePoints::block_of(there), known.map);
  };
  const auto from_afar = plane();
  for (std::uint64_t i = 0; i < 3; ++i) learn(1.5, 3.01, 100 + i);
  const auto from_near = plane();
  ASSERT_TRUE(from_afar && from_near);
  EXPECT_GT(std::sqrt(from_afar->doubt), 0.005);
  EXPECT_LT(from_near->doubt, from_afar->doubt / 4);
  EXPECT_NEAR(from_near->point.x(), 3.01, 0.004);
}

TEST(SurfacePoints, KeepToTheirBound) {
  KnownRoom known(SyntheticRoom::furnished());
  SurfacePoints few(known.map.resolution(), 1000);
  const std::size_t most = 2 * 1024 * 72;
  for (std::uint64_t i = 0; i < 12; ++i) {
    const Eigen::Isometry3d pose = camera_pose(kEye, 0.5 * static_cast<double>(i), 0.2);
    known.learn(pose, i);
    few.add(known.patches, pose, known.map);
    EXPECT_LE(few.voxels(), 1024U);
    EXPECT_LE(few.bytes(), most);
  }
  EXPECT_EQ(few.voxels(), 1024U);
  EXPECT_GT(known.surfaces.voxels(), 3000U);
}

TEST(SurfacePoints, MakeRoomByForgettingWhatTheMapDoesNotKnow) {
  KnownRoom known(SyntheticRoom::furnished());
  SurfacePoints few(known.map.resolution(), 1000);
  for (std::uint64_t i = 0; i < 8; ++i) {
    const Eigen::Isometry3d away = camera_pose(kEye, 0.2 * static_cast<double>(i) - 0.8, 0.2);
    known.learn(away, i);
    few.add(known.patches, away, known.map);
  }
  ASSERT_EQ(few.voxels(), 1024U);
  KnownRoom later(known.room);  // where the robot has walked on to, the map knows other things
  const Eigen::Isometry3d here = camera_pose(kEye, -2.8, 0.1);
  for (std::uint64_t i = 0; i < 3; ++i) {
    later.learn(here, i);
    few.add(later.patches, here, later.map);
  }
  EXPECT_LE(few.voxels(), 1024U);
  EXPECT_TRUE(few.plane(later.map.index({-2.61, -0.8, 1.1}), later.map));
}

}  // namespace
}  // namespace headway::nav
