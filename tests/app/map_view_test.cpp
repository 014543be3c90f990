#include "app/map_view.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "app/voxel_rays.h"

namespace headway::app {
namespace {

using nav::Voxel;
using nav::VoxelMap;
using Index = VoxelMap::Index;

nav::VoxelMapConfig box(double side, double res = 0.1) {
  nav::VoxelMapConfig config;
  config.resolution = res;
  config.lowest = Eigen::Vector3d::Constant(-side);
  config.highest = Eigen::Vector3d::Constant(side);
  return config;
}

/// Some bricks empty, some unseen, some mixed.
VoxelMap random_map(std::uint64_t seed) {
  VoxelMap map(box(1.2));
  std::mt19937_64 random(seed);
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    const auto kind = random() % 4;
    const auto values = map.edit(b);
    for (nav::LogOdds& v : values) {
      const auto dice = random() % 100;
      if (kind == 1) v = -20;
      if (kind >= 2) v = dice < 3 ? nav::LogOdds{20} : dice < 60 ? nav::LogOdds{-20} : nav::log_odds::kUnseen;
    }
    map.settle(b, Time{});
  }
  return map;
}

VoxelRays::Config everything(const VoxelMap& map) { return {map.lowest(), map.highest(), false, 0.4, true}; }

Eigen::Vector3d random_unit(std::mt19937_64& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 * 2 - 1; };
  for (;;) {
    const Eigen::Vector3d v(uniform(), uniform(), uniform());
    if (v.norm() > 0.1 && v.norm() <= 1) return v.normalized();
  }
}

RC_GTEST_PROP(VoxelRays, MeetTheFirstOccupiedVoxelThatFineStepsMeet, (std::uint64_t seed)) {
  const VoxelMap map = random_map(seed);
  std::mt19937_64 random(seed ^ 99);
  const VoxelRays rays(map, everything(map));
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d direction = random_unit(random);
    const Eigen::Vector3d eye = (i % 2 == 0 ? 3.0 : 0.3) * random_unit(random);
    const RayResult found = rays.walk(eye, direction);
    const double end = found.surface ? found.surface->t : 8;
    // Everything before the surface is not occupied (corners that are cut by less than a step do not count)
    // ...
    constexpr double kStep = 0.001;
    for (double t = 0; t < end - kStep; t += kStep)
      RC_ASSERT(map.at_point(eye + t * direction) != Voxel::kOccupied);
    // ... and the surface is that of an occupied voxel whose face lies there.
    if (!found.surface) continue;
    RC_ASSERT(map.at(found.surface->voxel) == Voxel::kOccupied);
    const Eigen::Vector3d off = (eye + end * direction - map.centre(found.surface->voxel)).cwiseAbs();
    if (end > 0) RC_ASSERT(std::abs(off.maxCoeff() - 0.05) < 1e-6);
    RC_ASSERT(direction[found.surface->axis] * found.surface->side <= 0);
  }
}

RC_GTEST_PROP(VoxelRays, SetAVeilWhereEmptyTurnsUnseen, (std::uint64_t seed)) {
  const VoxelMap map = random_map(seed);
  std::mt19937_64 random(seed ^ 7);
  const VoxelRays rays(map, everything(map));
  const Eigen::Vector3d eye = 3 * random_unit(random);
  const RayResult found = rays.walk(eye, (0.5 * random_unit(random) - eye).normalized());
  const Eigen::Vector3d direction = (found.surface ? 1 : 1) * (Eigen::Vector3d::Zero() - eye).normalized();
  const RayResult straight = rays.walk(eye, direction);
  for (int i = 0; i < straight.veil_count; ++i) {
    const VoxelFace& veil = straight.veils[static_cast<std::size_t>(i)];
    RC_ASSERT(map.at(veil.voxel) == Voxel::kUnseen);
    Index before = veil.voxel;
    before[veil.axis] += veil.side;
    RC_ASSERT(map.at(before) == Voxel::kEmpty);
  }
}

/// A wall at x = 0.5..0.6, with empty space this side of it and nothing known beyond.
VoxelMap wall() {
  VoxelMap map(box(1.6));
  for (int z = 0; z < map.size().z(); ++z) {
    for (int y = 0; y < map.size().y(); ++y) {
      for (int x = 0; x < map.size().x(); ++x) {
        const double at = map.centre({x, y, z}).x();
        if (at < 0.5) map.set({x, y, z}, -20, Time{});
        if (at > 0.5 && at < 0.6) map.set({x, y, z}, 40, Time{});
      }
    }
  }
  return map;
}

TEST(VoxelRays, LookThroughTheBackOfAWall) {
  const VoxelMap map = wall();
  VoxelRays::Config config = everything(map);
  const Eigen::Vector3d behind(3, 0.02, 0.02), before(-3, 0.02, 0.02), x = Eigen::Vector3d::UnitX();
  EXPECT_TRUE(VoxelRays(map, config).walk(behind, -x).surface);
  config.seen_sides_only = true;
  EXPECT_FALSE(VoxelRays(map, config).walk(behind, -x).surface);
  const auto seen = VoxelRays(map, config).walk(before, x).surface;
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->t, 3.5, 1e-9);
  EXPECT_EQ(seen->axis, 0);
  EXPECT_EQ(seen->side, -1);
}

TEST(VoxelRays, LeaveOutWhatLiesOutsideTheLimits) {
  const VoxelMap map = wall();
  VoxelRays::Config config = everything(map);
  config.highest.x() = 0.4;
  EXPECT_FALSE(VoxelRays(map, config).walk({-3, 0.02, 0.02}, Eigen::Vector3d::UnitX()).surface);
}

TEST(MapView, ShowsTheWallInTheMiddleAndTheSkyAboveIt) {
  const VoxelMap map = wall();
  MapViewConfig config;
  config.width = 200, config.height = 140;
  config.floor_height = MapViewConfig::kNoFloor;
  Lookout from{{-4, 0, 0}, {0, 0, 0}, 1.2};
  const cv::Mat out = map_view(map, from, config);
  ASSERT_EQ(out.size(), cv::Size(200, 140));
  EXPECT_EQ(out.type(), CV_8UC3);
  EXPECT_NE(out.at<Colour>(70, 120), out.at<Colour>(3, 197));  // the wall, and the sky
}

TEST(MapView, PutsTheRobotBeforeTheWall) {
  const VoxelMap map = wall();
  MapViewConfig config;
  config.width = 200, config.height = 140;
  config.floor_height = -1.5;
  const Lookout from{{-4, 0, 0}, {0, 0, 0}, 1.2};
  const cv::Mat without = map_view(map, from, config);
  MapFigures figures;
  figures.robot = Pose2{-0.5, 0, 0};
  const cv::Mat with = map_view(map, from, config, figures);
  figures.robot = Pose2{2, 0, 0};  // behind the wall
  const cv::Mat hidden = map_view(map, from, config, figures);
  EXPECT_NE(with.at<Colour>(80, 100), without.at<Colour>(80, 100));
  EXPECT_EQ(hidden.at<Colour>(80, 100), without.at<Colour>(80, 100));
}

TEST(MapView, LaysPathAndFeetOnTheFloor) {
  VoxelMap map(box(1.6));
  for (int y = 0; y < map.size().y(); ++y) {
    for (int x = 0; x < map.size().x(); ++x) {
      for (int z = 0; z < map.size().z(); ++z)
        map.set({x, y, z}, map.centre({x, y, z}).z() < 0 ? 40 : -20, Time{});
    }
  }
  MapViewConfig config;
  config.width = 160, config.height = 120;
  const Lookout above{{0, 0, 5}, {0, 0, 0}, 0.6};
  MapFigures figures;
  figures.path = {{-1, 0}, {1, 0}};
  figures.feet = {{{0, 0.5, 0}, hal::Foot::kLeft, true}};
  const cv::Mat plain = map_view(map, above, config), drawn = map_view(map, above, config, figures);
  EXPECT_NE(plain.at<Colour>(60, 80), drawn.at<Colour>(60, 80));  // the path runs through the middle
  EXPECT_EQ(plain.at<Colour>(100, 100), drawn.at<Colour>(100, 100));
}

TEST(MapView, VeilsUnseenSpaceOnRequest) {
  VoxelMap map(box(1.6));
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    const bool low = map.brick_at(b).x() < 2;
    for (nav::LogOdds& v : map.edit(b)) v = low ? nav::LogOdds{-20} : nav::log_odds::kUnseen;
    map.settle(b, Time{});
  }
  MapViewConfig config;
  config.width = 100, config.height = 80;
  config.floor_height = MapViewConfig::kNoFloor;
  const Lookout from{{-4, 0, 0}, {0, 0, 0}, 0.6};
  const Colour sky = map_view(map, from, config).at<Colour>(60, 80);
  config.show_unseen = true;
  EXPECT_NE(map_view(map, from, config).at<Colour>(60, 80), sky);
}

RC_GTEST_PROP(BirdView, HoldsEveryOccupiedVoxel, (std::uint64_t seed)) {
  std::mt19937_64 random(seed);
  VoxelMap map(box(1.6));
  const Index n = map.size();
  std::vector<Index> occupied;
  for (int i = 0; i < 30; ++i) {
    occupied.push_back({static_cast<int>(random() % static_cast<unsigned>(n.x())),
                        static_cast<int>(random() % static_cast<unsigned>(n.y())),
                        static_cast<int>(random() % static_cast<unsigned>(n.z()))});
    map.set(occupied.back(), 40, Time{});
  }
  const MapViewConfig config;
  const double azimuth = static_cast<double>(random() % 628) / 100,
               elevation = static_cast<double>(random() % 140) / 100;
  const Lookout from = bird_view(map, config, azimuth, elevation);
  const Eigen::Vector3d ahead = (from.target - from.eye).normalized();
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized(), up = right.cross(ahead);
  const double across = std::tan(from.field / 2), upward = across * config.height / config.width;
  for (const Index& i : occupied) {
    const Eigen::Vector3d p = map.centre(i) - from.eye;
    RC_ASSERT(p.dot(ahead) > 0);
    RC_ASSERT(std::abs(p.dot(right)) <= across * p.dot(ahead));
    RC_ASSERT(std::abs(p.dot(up)) <= upward * p.dot(ahead));
  }
}

TEST(BirdView, OfAnEmptyMapStillLooksAtIt) {
  const VoxelMap map(box(1.0));
  const Lookout from = bird_view(map, {});
  EXPECT_TRUE(from.eye.allFinite());
  EXPECT_NEAR(from.target.norm(), 0, 0.5);
}

}  // namespace
}  // namespace headway::app
