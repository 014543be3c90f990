// Views in the map, on each instruction set that was compiled and that this processor has. The plain one
// (HWY_SCALAR) goes voxel by voxel in whole numbers; all others are held to it.
#include "tests/every_target.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "nav/integrate.h"
#include "room_map.h"
#include "synthetic_room.h"

namespace headway::nav {
namespace {

struct Mapped {
  VoxelMap map;
  IntegrationStats stats;
};

/// Two looks at the room, with the robot's own arm before the second one.
Mapped mapped(double resolution, int width, double sigma) {
  const SyntheticRoom room = SyntheticRoom::furnished();
  const vision::PinholeCamera camera = camera_of(width, 180, 40 * kDegree);
  const Noise noise{.disparity_sigma = sigma, .correlation = 2, .outliers = 0.01, .seed = 3};
  IntegrationConfig config;
  config.own_body = {{{0.2, -0.2, -0.5}, {0.9, 0.2, 0.1}}};
  Integrator integrator(config);
  Mapped result{room_map(resolution), {}};
  for (const double yaw : {-0.4, 0.9}) {
    const Eigen::Isometry3d pose = camera_pose({-1.2, 0.1, 1.37}, yaw, 0.3);
    vision::RangeView view = look(room, camera, pose, noise, sigma);
    view.weight.assign(view.depth.size(), 1.0F);
    for (std::size_t i = 0; i < view.weight.size(); i += 11) view.weight[i] = 0.1F;
    const Eigen::Isometry3d map_from_body(Eigen::Translation3d(-1.2, 0, 1));
    result.stats = integrator.integrate(result.map, view, pose, at_seconds(yaw), map_from_body);
  }
  return result;
}

int greatest_difference(const VoxelMap& a, const VoxelMap& b) {
  int greatest = 0;
  for (std::size_t brick = 0; brick < a.brick_count(); ++brick) {
    for (std::size_t i = 0; i < kBrickVoxels; ++i)
      greatest = std::max(greatest, std::abs(a.values(brick)[i] - b.values(brick)[i]));
  }
  return greatest;
}

/// Sizes that are no multiple of any vector, images that are halved twice, once and not at all, and a sigma
/// far wider than a voxel.
TEST(Integrate, GivesTheSameMapOnEveryInstructionSet) {
  struct Case {
    double resolution;
    int width;
    double sigma;
  };
  for (const Case& c :
       {Case{0.1, 163, 0.1}, Case{0.05, 163, 0.2}, Case{0.02, 101, 0.2}, Case{0.05, 339, 0.6}}) {
    hwy::GetChosenTarget().Update(HWY_SCALAR);
    const Mapped plain = mapped(c.resolution, c.width, c.sigma);
    EXPECT_GT(plain.stats.hits, 300U);
    EXPECT_GT(plain.stats.misses, 1000U);
    headway::test::on_every_target([&](const std::string& name) {
      const Mapped on_target = mapped(c.resolution, c.width, c.sigma);
      EXPECT_EQ(greatest_difference(plain.map, on_target.map), 0) << name << " at " << c.resolution;
      EXPECT_EQ(plain.stats.hits, on_target.stats.hits) << name;
      EXPECT_EQ(plain.stats.misses, on_target.stats.misses) << name;
      EXPECT_EQ(plain.stats.first_seen, on_target.stats.first_seen) << name;
      EXPECT_EQ(plain.stats.rejected, on_target.stats.rejected) << name;
      for (std::size_t b = 0; b < plain.map.brick_count(); ++b) {
        const BrickSummary &p = plain.map.summary(b), &t = on_target.map.summary(b);
        ASSERT_TRUE(p.unseen == t.unseen && p.occupied == t.occupied && p.changed == t.changed) << name;
        const auto values = on_target.map.values(b);
        ASSERT_EQ(t.unseen, std::ranges::count(values, log_odds::kUnseen)) << name;
        ASSERT_EQ(t.occupied, std::ranges::count_if(values, [](LogOdds v) { return v >= 0; })) << name;
      }
      for (int y = 0; y < plain.map.size().y(); ++y)
        for (int x = 0; x < plain.map.size().x(); ++x)
          ASSERT_EQ(plain.map.floor_seen_at(x, y), on_target.map.floor_seen_at(x, y)) << name;
    });
  }
}

}  // namespace
}  // namespace headway::nav
