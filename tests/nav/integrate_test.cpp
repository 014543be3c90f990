#include "nav/integrate.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "hal/error.h"
#include "map_score.h"
#include "nav/floor_map.h"
#include "room_map.h"
#include "synthetic_room.h"
#include "tests/heap_count.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
using Index = VoxelMap::Index;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

vision::PinholeCamera narrow_camera() { return camera_of(170, 240, 33 * kDegree); }

/// Nine or more directions of gaze from about the middle of the room.
std::vector<Isometry3d> looks_around() {
  std::vector<Isometry3d> poses;
  for (const double down : {-0.26, 0.17, 0.6}) {
    for (double yaw = -1.65; yaw < 1.7; yaw += 0.55)
      poses.push_back(camera_pose({-1.2, 0.1 * yaw, 1.37}, yaw, down));
  }
  return poses;
}

/// Two passes over all poses.
VoxelMap mapped(const SyntheticRoom& room, const vision::PinholeCamera& camera,
                const std::vector<Isometry3d>& poses, Noise noise, double sigma) {
  VoxelMap map = room_map();
  Integrator integrator;
  for (int pass = 0; pass < 2; ++pass) {
    for (const Isometry3d& pose : poses) {
      integrator.integrate(map, look(room, camera, pose, noise, sigma), pose,
                           at_seconds(static_cast<double>(noise.seed)));
      ++noise.seed;
    }
  }
  return map;
}

TEST(Integrate, MapsARoomFromExactViews) {
  const auto room = SyntheticRoom::furnished();
  const MapScore s =
      score(mapped(room, narrow_camera(), looks_around(), {}, 0.05), room, narrow_camera(), looks_around());
  EXPECT_GE(s.surface_occupied, 0.99);
  EXPECT_EQ(s.surface_emptied, 0);
  EXPECT_GE(s.air_empty, 0.98);
  EXPECT_EQ(s.air_occupied, 0);
  EXPECT_EQ(s.solid_emptied, 0);
  EXPECT_EQ(s.pole_occupied, 1);
}

TEST(Integrate, MapsARoomThroughCorrelatedNoiseAndGrossOutliers) {
  const auto room = SyntheticRoom::furnished();
  for (const int correlation : {1, 2, 4}) {
    const Noise noise{.disparity_sigma = 0.15, .correlation = correlation, .outliers = 0.005, .seed = 100};
    const MapScore s = score(mapped(room, narrow_camera(), looks_around(), noise, 0.15), room,
                             narrow_camera(), looks_around());
    EXPECT_GE(s.surface_occupied, 0.985) << "noise over " << correlation << " px";
    EXPECT_LE(s.surface_emptied, 0.0005);
    EXPECT_GE(s.air_empty, 0.90);
    EXPECT_LE(s.air_occupied, 0.01) << "more than 10 cm from all surfaces";
    EXPECT_EQ(s.solid_emptied, 0);
    EXPECT_GE(s.pole_occupied, 0.99);
  }
}

struct Wall {
  int holes = 0, occupied = 0;  ///< voxels: of the wall itself, not occupied; occupied anywhere
};

/// A wall 2.63 m in front of the camera, in voxels of 2 cm, after one look.
Wall wall_seen(int correlation, const IntegrationConfig& config) {
  SyntheticRoom room;  // empty
  const vision::PinholeCamera camera = narrow_camera();
  const Isometry3d pose = camera_pose({0, 0, 1.3}, 0, 0);
  VoxelMap map = room_map(0.02);
  const double sigma = 0.4;  // [px]: 7 cm at the wall
  integrate(map, look(room, camera, pose, {.disparity_sigma = sigma, .correlation = correlation}, sigma),
            pose, at_seconds(1), config);
  Wall wall;
  for_each_known(map, [&](const Index& i) { wall.occupied += map.at(i) == Voxel::kOccupied; });
  for (double y = -0.7; y < 0.7; y += 0.02) {
    for (double z = 0.4; z < 2.2; z += 0.02)
      wall.holes += map.at_point({room.walls.highest.x() - 0.005, y, z}) != Voxel::kOccupied;
  }
  return wall;
}

TEST(Integrate, HitsReachAsFarAsTheViewsOwnErrors) {
  const Wall alone = wall_seen(1, {}), together = wall_seen(4, {});
  IntegrationConfig blind;
  blind.hit_errors = 0;
  EXPECT_EQ(wall_seen(1, blind).occupied, alone.occupied)
      << "means over pixels that err alone are good enough";
  EXPECT_GT(together.occupied, alone.occupied * 5 / 4)
      << "where neighbours err together, it may be elsewhere";
  EXPECT_LT(2 * together.holes, wall_seen(4, blind).holes);
}

TEST(Integrate, PunchesNoHolesIntoWallsWhenSigmaIsFarWiderThanAVoxel) {
  const auto room = SyntheticRoom::furnished();
  const Noise noise{.disparity_sigma = 0.6, .correlation = 2, .outliers = 0, .seed = 7};  // 24 cm at 4 m
  const MapScore s =
      score(mapped(room, narrow_camera(), looks_around(), noise, 0.6), room, narrow_camera(), looks_around());
  EXPECT_LE(s.surface_emptied, 0.001);
  EXPECT_GE(s.surface_occupied, 0.97);
  EXPECT_EQ(s.solid_emptied, 0);
}

/// A wall across the view at depth `z`, seen from (0, 0, 1) along x.
struct WallView {
  Isometry3d pose = camera_pose({0, 0, 1}, 0, 0);
  vision::RangeView view;
  explicit WallView(double z, double sigma = 0.01) {
    view.camera = narrow_camera();
    view.near = 0.5;
    view.far = 5;
    const auto pixels = static_cast<std::size_t>(view.camera.width * view.camera.height);
    view.depth.assign(pixels, static_cast<float>(z));
    view.sigma_depth.assign(pixels, static_cast<float>(sigma));
  }
  /// Depth `z` in the pixels u0..u1, v0..v1.
  void put(int u0, int v0, int u1, int v1, float z) {
    for (int v = v0; v <= v1; ++v) {
      for (int u = u0; u <= u1; ++u) view.depth[view.index(u, v)] = z;
    }
  }
};

TEST(Integrate, SaysWhatIsKnownAlongOneRay) {
  VoxelMap map = room_map();
  const WallView wall(2.02);
  integrate(map, wall.view, wall.pose, at_seconds(1));
  for (double x = 0.025; x < 2.7; x += 0.05) {
    const Voxel seen = map.at_point({x, 0.025, 1.025});
    if (x < 0.5) {
      EXPECT_EQ(seen, Voxel::kUnseen) << x << ": nearer than the sensor can measure";
    }
    if (x > 0.5 && x < 1.96) {
      EXPECT_EQ(seen, Voxel::kEmpty) << x;
    }
    if (x > 2.0 && x < 2.05) {
      EXPECT_EQ(seen, Voxel::kOccupied) << x;
    }
    if (x > 2.06) {
      EXPECT_EQ(seen, Voxel::kUnseen) << x << ": behind the wall";
    }
  }
}

TEST(Integrate, KeepsThreeSigmaInFrontOfASurfaceFromBeingEmptied) {
  VoxelMap map = room_map();
  const WallView wall(2.02, 0.1);
  integrate(map, wall.view, wall.pose, at_seconds(1));
  EXPECT_EQ(map.at_point({1.675, 0.025, 1.025}), Voxel::kEmpty);
  EXPECT_EQ(map.at_point({1.725, 0.025, 1.025}), Voxel::kUnseen);
}

TEST(Integrate, SpreadsHitsMoreThinlyTheWiderSigmaIs) {
  const auto hit = [](double sigma) {
    VoxelMap map = room_map();
    const WallView wall(2.02, sigma);
    integrate(map, wall.view, wall.pose, at_seconds(1));
    return std::pair(map.value(map.index({2.025, 0.025, 1.025})),
                     map.value(map.index({2.125, 0.025, 1.025})));
  };
  EXPECT_EQ(hit(0).first, log_odds::kHit);
  EXPECT_EQ(hit(0).second, log_odds::kUnseen);
  EXPECT_GE(hit(0.4).first, log_odds::kHit / 2) << "the measured point's own voxel";
  EXPECT_GT(hit(0.4).second, 0);
  EXPECT_LT(hit(0.4).second, log_odds::kHit / 3);
}

TEST(Integrate, TakesARangeBeyondFarAsEmptyUpToFarAndNoFarther) {
  VoxelMapConfig config;
  config.lowest = {-1, -1, 0};
  config.highest = {9, 1, 2};
  VoxelMap map(config);
  const WallView wall(7.0);
  integrate(map, wall.view, wall.pose, at_seconds(1));
  EXPECT_EQ(map.at_point({4.975, 0.025, 1.025}), Voxel::kEmpty);
  for_each_known(map, [&](const Index& i) {
    EXPECT_LT(map.centre(i).x(), 5);
    EXPECT_EQ(map.at(i), Voxel::kEmpty);
  });
}

TEST(Integrate, SaysNothingWhereNothingIsMeasuredOrNearerThanNear) {
  for (const float depth : {kNan, 0.3F, 0.0F, -1.0F, std::numeric_limits<float>::infinity()}) {
    VoxelMap map = room_map();
    WallView wall(1);
    wall.put(0, 0, wall.view.camera.width - 1, wall.view.camera.height - 1, depth);
    const IntegrationStats stats = integrate(map, wall.view, wall.pose, at_seconds(1));
    EXPECT_EQ(stats.samples, 0U) << depth;
    for_each_known(map, [&](const Index&) { ADD_FAILURE() << depth; });
  }
}

TEST(Integrate, SeesThroughSingleHolesOfASurfaceAsThroughTheRestOfIt) {
  const WallView whole(2.02);
  WallView holed = whole;
  for (int v = 6; v + 1 < holed.view.camera.height; v += 6) {
    for (int u = 6; u + 1 < holed.view.camera.width; u += 6) holed.put(u, v, u + 1, v + 1, kNan);
  }
  VoxelMap map = room_map(), holed_map = room_map();
  integrate(map, whole.view, whole.pose, at_seconds(1));
  integrate(holed_map, holed.view, holed.pose, at_seconds(1));
  for_each_known(map, [&](const Index& i) { ASSERT_EQ(holed_map.at(i), map.at(i)) << i.transpose(); });
}

TEST(Integrate, SeesAPoleThinnerThanAVoxelInEveryView) {
  VoxelMap map = room_map();
  Integrator integrator;
  for (int frame = 0; frame < 20; ++frame) {
    WallView wall(2.5, 0.02);
    wall.put(80, 0, 82, 239, 1.5F + 0.01F * static_cast<float>(frame % 3));  // 1.6 cm wide
    integrator.integrate(map, wall.view, wall.pose, at_seconds(frame));
  }
  for (double z = 0.45; z < 1.6; z += 0.05) {
    bool there = false;
    for (double y = -0.05; y <= 0.1; y += 0.05) there |= map.at_point({1.525, y, z}) == Voxel::kOccupied;
    EXPECT_TRUE(there) << z;
  }
}

/// Two pixels wide, wherever they fall among those that are read together, and the robot stands still.
TEST(Integrate, SeesLevelAndUprightBarsOfTwoPixelsAtEveryReduction) {
  for (const double far : {12.0, 5.0, 3.0}) {  // the view as it is, at half, and at a quarter of its size
    for (const bool level : {false, true}) {
      for (int phase = 0; phase < 4; ++phase) {
        SCOPED_TRACE(testing::Message()
                     << "far " << far << (level ? ", level" : ", upright") << " at " << phase);
        VoxelMap map = room_map();
        Integrator integrator;
        WallView wall(2.5, 0.02);
        wall.view.far = far;
        const int u = 80 + phase, v = 120 + phase;
        if (level)
          wall.put(0, v, 169, v + 1, 1.5F);
        else
          wall.put(u, 0, u + 1, 239, 1.5F);
        for (int frame = 0; frame < 20; ++frame)
          integrator.integrate(map, wall.view, wall.pose, at_seconds(frame));
        for (double along = -0.3; along < 0.3; along += 0.05) {
          const auto at = [&](double beside, double x) {
            const vision::PinholeCamera& c = wall.view.camera;
            const Vector3d p = level ? c.point(c.cx, v + 0.5, 1.5) : c.point(u + 0.5, c.cy, 1.5);
            const Vector3d middle = wall.pose * p;
            return map.at_point(level ? Vector3d(x, along, middle.z() + beside)
                                      : Vector3d(x, middle.y() + beside, 1 + along));
          };
          bool there = false;
          for (const double x : {1.475, 1.525})
            for (const double beside : {-0.03, 0.0, 0.03}) there |= at(beside, x) == Voxel::kOccupied;
          EXPECT_TRUE(there) << along;
        }
      }
    }
  }
}

TEST(Integrate, LetsAnOutlierLeaveNoTraceHoweverOftenItsPlaceWasSeenEmpty) {
  for (const int looks : {0, 10}) {
    VoxelMap map = room_map();
    WallView wall(2.02);
    for (int k = 0; k < looks; ++k) integrate(map, wall.view, wall.pose, at_seconds(k));
    wall.put(80, 100, 80, 100, 1.2F);
    wall.put(30, 30, 31, 31, 1.2F);  // two by two pixels
    integrate(map, wall.view, wall.pose, at_seconds(looks));
    for_each_known(map, [&](const Index& i) {
      if (map.at(i) == Voxel::kOccupied) {
        EXPECT_GT(map.centre(i).x(), 1.95);
      }
    });
  }
}

TEST(Integrate, FreesWhatHasGoneWithinThreeViewsAndNotAfterOne) {
  VoxelMap map = room_map();
  Integrator integrator;
  WallView with_box(2.5);
  with_box.put(60, 80, 110, 160, 1.52F);
  for (int frame = 0; frame < 10; ++frame)
    integrator.integrate(map, with_box.view, with_box.pose, at_seconds(frame));
  const Vector3d front(1.525, 0.025, 1.025);
  ASSERT_EQ(map.at_point(front), Voxel::kOccupied);
  const WallView without(2.5);
  int views = 0;
  while (map.at_point(front) == Voxel::kOccupied && views < 50) {
    integrator.integrate(map, without.view, without.pose, at_seconds(10 + views));
    ++views;
  }
  EXPECT_EQ(views, 3);
}

/// A map that was seen empty before a wall at 2.5 m, twenty times.
VoxelMap long_empty(Integrator& integrator, double sigma) {
  VoxelMap map = room_map();
  const WallView wall(2.5, sigma);
  for (int frame = 0; frame < 20; ++frame) integrator.integrate(map, wall.view, wall.pose, at_seconds(frame));
  return map;
}

WallView box_before_wall(double sigma) {
  WallView view(2.5, sigma);
  view.put(60, 80, 110, 160, 1.52F);
  return view;
}

// However wide sigma is: but then only in the voxels that hold the points themselves.
TEST(Integrate, ShowsWhatComesInTheFirstViewHoweverOftenItsPlaceWasSeenEmpty) {
  for (const double sigma : {0.002, 0.02, 0.1}) {
    Integrator integrator;
    VoxelMap map = long_empty(integrator, sigma);
    const WallView with_box = box_before_wall(sigma);
    ASSERT_EQ(map.at_point({1.525, 0.025, 1.025}), Voxel::kEmpty);
    integrator.integrate(map, with_box.view, with_box.pose, at_seconds(20));
    EXPECT_EQ(map.at_point({1.525, 0.025, 1.025}), Voxel::kOccupied) << sigma;
    EXPECT_EQ(map.at_point({1.425, 0.025, 1.025}), Voxel::kEmpty) << sigma;
    EXPECT_EQ(map.at_point({1.625, 0.025, 1.025}), Voxel::kEmpty) << sigma;
  }
}

TEST(Integrate, TakesTwoWideLooksForWhatComesWhereMatchesMayBeWrong) {
  const auto views_until_seen = [](double sigma) {
    Integrator integrator;
    VoxelMap map = long_empty(integrator, sigma);
    WallView with_box = box_before_wall(sigma);
    with_box.view.weight.assign(with_box.view.depth.size(), 1);
    int views = 0;
    for (; views < 10 && map.at_point({1.525, 0.025, 1.025}) != Voxel::kOccupied; ++views)
      integrator.integrate(map, with_box.view, with_box.pose, at_seconds(20 + views));
    return views;
  };
  EXPECT_EQ(views_until_seen(0.002), 1);
  EXPECT_EQ(views_until_seen(0.1), 2);
}

TEST(Integrate, ForgetsAGhostSeenOnceWithinThreeViews) {
  VoxelMap map = room_map();
  WallView ghost(2.5);
  ghost.put(60, 80, 110, 160, 1.52F);
  integrate(map, ghost.view, ghost.pose, at_seconds(0));
  const WallView without(2.5);
  for (int frame = 1; frame <= 3; ++frame) integrate(map, without.view, without.pose, at_seconds(frame));
  EXPECT_EQ(map.at_point({1.525, 0.025, 1.025}), Voxel::kEmpty);
}

TEST(Integrate, DoesNotMapTheRobotsOwnBody) {
  WallView arm(2.02);
  arm.put(0, 150, 169, 239, 0.9F);
  IntegrationConfig config;
  config.own_body = {{{0.4, -0.6, -0.6}, {1.1, 0.6, -0.1}}};
  const Isometry3d map_from_body(Eigen::Translation3d(0, 0, 1));
  VoxelMap map = room_map(), naive = room_map();
  const IntegrationStats stats =
      Integrator(config).integrate(map, arm.view, arm.pose, at_seconds(1), map_from_body);
  integrate(naive, arm.view, arm.pose, at_seconds(1));
  const Vector3d on_arm(0.925, 0.025, 0.775);
  EXPECT_EQ(naive.at_point(on_arm), Voxel::kOccupied);
  EXPECT_EQ(map.at_point(on_arm), Voxel::kUnseen);
  EXPECT_EQ(map.at_point({2.025, 0.025, 1.175}), Voxel::kOccupied) << "the wall beside it is still seen";
  EXPECT_GT(stats.rejected, 1000U);
}

TEST(Integrate, StampsTheFloorWhereItWasSeenAndOnlyThere) {
  const SyntheticRoom room = SyntheticRoom::furnished();
  VoxelMap map = room_map();
  const Isometry3d down = camera_pose({-1.5, 0, 1.4}, 0, 40 * kDegree);
  integrate(map, look(room, narrow_camera(), down), down, at_seconds(5));
  const auto seen_at = [&](double x, double y) {
    const Index i = map.index({x, y, 0});
    return map.floor_seen_at(i.x(), i.y());
  };
  EXPECT_EQ(seen_at(0, 0), at_seconds(5));
  EXPECT_EQ(seen_at(-1.5, 0), kNever) << "below the camera";
  EXPECT_EQ(seen_at(0, 1.5), kNever) << "beside the field";

  VoxelMap wall_map = room_map();
  const WallView wall(2.02);  // the view ends 5 cm above the floor at the wall
  integrate(wall_map, wall.view, wall.pose, at_seconds(6));
  const Index at_wall = wall_map.index({2.025, 0.025, 0}), before = wall_map.index({1.525, 0.025, 0});
  EXPECT_EQ(wall_map.floor_seen_at(at_wall.x(), at_wall.y()), at_seconds(6)) << "an obstacle stands there";
  EXPECT_EQ(wall_map.floor_seen_at(before.x(), before.y()), kNever) << "only the air above was seen";
}

TEST(Integrate, BlocksNoFreeFloorByOutliers) {
  const SyntheticRoom room;
  VoxelMap map = room_map();
  Integrator integrator;
  const Noise noise{.disparity_sigma = 0.15, .correlation = 2, .outliers = 0.005, .seed = 1};
  std::vector<Isometry3d> poses;
  for (double yaw = -0.4; yaw < 0.5; yaw += 0.1)
    poses.push_back(camera_pose({-2, 0, 1.4}, yaw, 35 * kDegree));
  for (std::size_t k = 0; k < 3 * poses.size(); ++k) {
    Noise now = noise;
    now.seed = k;
    const Isometry3d& pose = poses[k % poses.size()];
    integrator.integrate(map, look(room, narrow_camera(), pose, now, 0.15), pose,
                         at_seconds(static_cast<double>(k)));
  }
  const FloorMap floor = floor_map(map);
  int free = 0, blocked = 0;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      const Eigen::Vector2d p = floor.grid.centre({x, y});
      if (std::abs(p.x()) > 2.3 || std::abs(p.y()) > 2.1) continue;
      free += floor.at({x, y}) == Floor::kFree;
      blocked += floor.at({x, y}) == Floor::kBlocked;
    }
  }
  EXPECT_GT(free, 1000);
  EXPECT_EQ(blocked, 0);
}

TEST(Integrate, TakesNoMemoryForWhatItHasSeenBefore) {
  const auto room = SyntheticRoom::furnished();
  VoxelMap map = room_map();
  Integrator integrator;
  std::vector<vision::RangeView> views;
  const std::vector<Isometry3d> poses = looks_around();
  for (const Isometry3d& pose : poses) views.push_back(look(room, narrow_camera(), pose));
  std::uint64_t before = 0;
  for (int pass = 0; pass < 2; ++pass) {
    before = heap_allocations();
    for (std::size_t k = 0; k < poses.size(); ++k) {
      integrator.integrate(map, views[k], poses[k], at_seconds(static_cast<double>(k)));
    }
  }
  EXPECT_EQ(heap_allocations(), before);
}

TEST(Integrate, RefusesViewsAndSettingsThatMakeNoSense) {
  VoxelMap map = room_map();
  WallView wall(2);
  Isometry3d lost = wall.pose;
  lost.translation().x() = std::nan("");
  EXPECT_THROW(integrate(map, wall.view, lost, at_seconds(1)), Error);
  wall.view.depth.pop_back();
  EXPECT_THROW(integrate(map, wall.view, wall.pose, at_seconds(1)), Error);
  IntegrationConfig config;
  config.free_sigmas = -1;
  EXPECT_THROW(Integrator{config}, InputError);
  config = {};
  config.hit_errors = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Integrator{config}, InputError);
  config = {};
  config.own_body = {{{0, 0, 0}, {1, -1, 1}}};
  EXPECT_THROW(Integrator{config}, InputError);
}

TEST(Integrate, IgnoresAViewFromOutsideOfTheMap) {
  VoxelMap map = room_map();
  const WallView wall(2);
  const Isometry3d away = camera_pose({50, 0, 1}, 0, 0);
  const IntegrationStats stats = integrate(map, wall.view, away, at_seconds(1));
  EXPECT_EQ(stats.hits + stats.misses, 0U);
}

}  // namespace
}  // namespace headway::nav
