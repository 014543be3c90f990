// OctoMap's rays say what a look shows; properties say what must hold whatever it shows.
#include "nav/view_gain.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "nav/integrate.h"
#include "nav/octomap_files.h"
#include "random_view.h"
#include "room_map.h"
#include "tests/every_target.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
using Index = VoxelMap::Index;

constexpr UsefulSpace kAll{-10, 10};

octomap::point3d point(const Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// How far along a ray of OctoMap's the first occupied voxel begins [m]; infinity where none does within
/// `most`.
double first_obstacle(const octomap::OcTree& tree, const Vector3d& eye, const Vector3d& direction,
                      double most) {
  constexpr bool kThroughUnseen = true;
  octomap::point3d centre, entry;
  if (!tree.castRay(point(eye), point(direction), centre, kThroughUnseen, most))
    return std::numeric_limits<double>::infinity();
  const double half = tree.getResolution() / 2;
  if (((Vector3d(centre.x(), centre.y(), centre.z()) - eye).cwiseAbs().array() <= half).all()) return 0;
  if (!tree.getRayIntersection(point(eye), point(direction), centre, entry))
    return (centre - point(eye)).norm();
  return (entry - point(eye)).norm();
}

/// Unseen voxels in the field that `hidden(centre)` does not say are hidden.
template <class Hidden>
std::size_t count_shown(const RandomView& r, const Hidden& hidden) {
  const vision::Polytope field = vision::moved(r.field, r.pose);
  std::size_t shown = 0;
  for (int z = 0; z < r.map.size().z(); ++z)
    for (int y = 0; y < r.map.size().y(); ++y)
      for (int x = 0; x < r.map.size().x(); ++x) {
        const Index i(x, y, z);
        if (r.map.at(i) != Voxel::kUnseen || !field.contains(r.map.centre(i))) continue;
        shown += !hidden(r.map.centre(i));
      }
  return shown;
}

TEST(ViewGain, CountsWhatOctoMapsRaysMeetBeforeTheFirstObstacle) {
  double sum = 0, sum_exact = 0, sum_off = 0, looks = 0;
  rc::check([&] {
    const RandomView r = any_view();
    const auto tree = to_octree(r.map);
    ViewGain gain(r.field, r.map.resolution(), kAll);
    const auto counted = static_cast<double>(gain.gain(r.map, r.pose));
    const Vector3d eye = r.pose.translation();
    // Along the ray to the voxel itself.
    const auto exact = static_cast<double>(count_shown(r, [&](const Vector3d& centre) {
      const Vector3d way = centre - eye;
      return first_obstacle(*tree, eye, way.normalized(), way.norm()) < way.norm();
    }));
    // Along the ray of the coarse image that passes nearest.
    const RayGrid& grid = gain.rays().grid();
    const auto by_image = static_cast<double>(count_shown(r, [&](const Vector3d& centre) {
      const Vector3d p = r.pose.inverse() * centre;
      const double u =
          std::floor((p.x() / p.z() - static_cast<double>(grid.x0)) / static_cast<double>(grid.step));
      const double v =
          std::floor((p.y() / p.z() - static_cast<double>(grid.y0)) / static_cast<double>(grid.step));
      const Vector3d ray(static_cast<double>(grid.x0) + (u + 0.5) * static_cast<double>(grid.step),
                         static_cast<double>(grid.y0) + (v + 0.5) * static_cast<double>(grid.step), 1);
      return first_obstacle(*tree, eye, (r.pose.linear() * ray).normalized(), 8) < p.z() * ray.norm();
    }));
    RC_ASSERT(std::abs(counted - by_image) <= 3 + 0.003 * by_image);
    sum += counted;
    sum_exact += exact;
    sum_off += std::abs(counted - exact);
    looks += 1;
  });
  ASSERT_GT(sum_exact, 20 * looks) << "or the test shows nothing";
  const double chance = 100 / looks;  // among fewer, a single one weighs more
  EXPECT_NEAR(sum / sum_exact, 1, 0.01 * chance) << "over " << looks << " looks";
  EXPECT_LT(sum_off, 0.02 * chance * sum_exact);  // one look by itself may miss much behind an edge
}

TEST(ViewGain, EndsEachRayWhereOctoMapsDoes) {
  std::size_t looks = 0, rays = 0, differ = 0;
  rc::check([&] {
    ++looks;
    const RandomView r = any_view();
    const auto tree = to_octree(r.map);
    ViewGain gain(r.field, r.map.resolution());
    gain.gain(r.map, r.pose);
    const RayGrid& grid = gain.rays().grid();
    double far = 0;
    for (const Vector3d& corner : r.field.corners) far = std::max(far, corner.z());
    for (int v = 0; v < grid.height; ++v)
      for (int u = 0; u < grid.width; ++u) {
        const auto along = [&](float first, int i) {
          return static_cast<double>(first) + (i + 0.5) * static_cast<double>(grid.step);
        };
        const Vector3d ray(along(grid.x0, u), along(grid.y0, v), 1);
        const double ours =
            static_cast<double>(gain.rays().reach()[static_cast<std::size_t>(v * gain.rays().stride() + u)]) *
            r.map.resolution() * ray.norm();
        const double theirs =
            first_obstacle(*tree, r.pose.translation(), (r.pose.linear() * ray).normalized(), 8);
        ++rays;
        if (std::min(ours, theirs) > far) continue;  // bricks beyond the field are not looked at
        differ += !(std::abs(ours - theirs) < 1e-3);
      }
  });
  ASSERT_GT(rays, 100 * looks);
  EXPECT_LE(differ, rays / 1000) << "but where a ray grazes an edge";
}

RC_GTEST_PROP(ViewGain, IsNothingWhereAllIsKnown, ()) {
  RandomView r = any_view();
  for (std::size_t b = 0; b < r.map.brick_count(); ++b) {
    for (LogOdds& value : r.map.edit(b)) value = value == log_odds::kUnseen ? log_odds::kMiss : value;
    r.map.settle(b, Time{});
  }
  RC_ASSERT(ViewGain(r.field, r.map.resolution(), kAll).gain(r.map, r.pose) == 0U);
}

RC_GTEST_PROP(ViewGain, NeverGrowsWhenMoreGetsKnown, ()) {
  RandomView r = any_view();
  ViewGain gain(r.field, r.map.resolution(), kAll);
  std::size_t before = gain.gain(r.map, r.pose);
  for (int i = 0; i < 5; ++i) {
    const LogOdds found = *rc::gen::element(log_odds::kMiss, log_odds::kHit);
    const auto seed = static_cast<std::uint64_t>(*rc::gen::inRange(1, 1 << 20));
    std::mt19937_64 random(seed);
    for (std::size_t b = 0; b < r.map.brick_count(); ++b) {
      for (LogOdds& value : r.map.edit(b))
        if (value == log_odds::kUnseen && uniform(random) < 0.1) value = found;
      r.map.settle(b, Time{});
    }
    const std::size_t after = gain.gain(r.map, r.pose);
    RC_ASSERT(after <= before);
    before = after;
  }
}

RC_GTEST_PROP(ViewGain, LeavesOutWhatStandsBehindAnObstacle, ()) {
  // A wall across the room, thin as it is, hides all behind it and nothing before it.
  RandomView r = any_view();
  const int wall = *rc::gen::inRange(18, 30);
  r.map = VoxelMap(r.map.config());
  r.pose = camera_pose({between(-1.5, 0), between(-0.3, 0.3), between(0.6, 1)}, between(-0.2, 0.2),
                       between(-0.2, 0.2));
  fill(r.map, {wall, -40, -40}, {wall + 1, 40, 40}, log_odds::kHit);
  ViewGain gain(r.field, r.map.resolution(), kAll);
  const std::size_t with_all = gain.gain(r.map, r.pose);
  fill(r.map, {wall + 1, 0, 0}, {32, 32, 16}, log_odds::kMiss);
  RC_ASSERT(gain.gain(r.map, r.pose) == with_all);
  fill(r.map, {0, 0, 0}, {wall, 32, 16}, log_odds::kMiss);
  RC_ASSERT(gain.gain(r.map, r.pose) == 0U);
}

RC_GTEST_PROP(ViewGain, CountsOnlyTheHeightsThatAreUseful, ()) {
  const RandomView r = any_view();
  const double cut = between(-0.2, 1.8);
  const auto gain = [&](double low, double high) {
    return ViewGain(r.field, r.map.resolution(), {low, high}).gain(r.map, r.pose);
  };
  RC_ASSERT(gain(-10, cut) + gain(cut, 10) == gain(-10, 10));
  RC_ASSERT(gain(5, 6) == 0U);
}

RC_GTEST_PROP(ViewGain, IsTheSameOnEveryInstructionSet, ()) {
  const RandomView r = any_view();
  ViewGain gain(r.field, r.map.resolution());
  const auto best = static_cast<double>(gain.gain(r.map, r.pose));
  headway::test::on_every_target([&](const char*) {
    // Where a voxel's centre lies on an edge to the last bit, rounding may decide.
    RC_ASSERT(std::abs(static_cast<double>(gain.gain(r.map, r.pose)) - best) <= 2);
  });
}

RC_GTEST_PROP(ViewGain, ExpectsNothingWhereItHasLookedAlready, ()) {
  const RandomView r = any_view();
  ViewGain gain(r.field, r.map.resolution(), kAll);
  const std::size_t fresh = gain.gain(r.map, r.pose);
  RC_ASSERT(gain.gain(r.map, r.pose, std::vector{r.pose}) == 0U);
  const Isometry3d turned = r.pose * Eigen::AngleAxisd(between(-1, 1), Vector3d::UnitY());
  RC_ASSERT(gain.gain(r.map, r.pose, std::vector{turned}) <= fresh);
  RC_ASSERT(gain.gain(r.map, r.pose) == fresh);
}

TEST(ViewGain, LooksAtTheOtherHalfWhenHalfHasBeenLookedAt) {
  const VoxelMap map = room_map(0.1);
  ViewGain gain(rig_field(0.3, 0.3, 0.5, 2.5, 0.0), 0.1, kAll);
  const Isometry3d pose = camera_pose({0, 0, 1.3}, 0, 0);
  const Isometry3d half_right = camera_pose({0, 0, 1.3}, -std::atan(0.3), 0);
  const auto all = static_cast<double>(gain.gain(map, pose));
  EXPECT_NEAR(static_cast<double>(gain.gain(map, pose, std::vector{half_right})) / all, 0.5, 0.05);
}

TEST(ViewGain, IsMostlyGainedByLookingThere) {
  const SyntheticRoom room = SyntheticRoom::furnished();
  const vision::PinholeCamera camera = camera_of(170, 240, 33 * kDegree);
  VoxelMap map = room_map();
  ViewGain gain(rig_field(std::tan(16.5 * kDegree), std::tan(16.5 * kDegree) * 240 / 170, 0.5, 5.0, 0), 0.05);
  double expected = 0, left = 0;
  for (double yaw = -1.65; yaw < 1.7; yaw += 0.3) {
    const Isometry3d pose = camera_pose({-1.2, 0, 1.37}, yaw, 0.3);
    expected += static_cast<double>(gain.gain(map, pose));
    integrate(map, look(room, camera, pose, {}, 0.05), pose, Time{});
    left += static_cast<double>(gain.gain(map, pose));
  }
  EXPECT_GT(expected, 20000);
  EXPECT_LT(left, 0.1 * expected) << "of what was to be seen at most";
}

TEST(ViewGain, RefusesFieldsWithoutEnd) {
  vision::Polytope endless = rig_field(0.3, 0.3, 0.5, 3);
  endless.directions = {Vector3d::UnitZ()};
  EXPECT_THROW(ViewGain(endless, 0.05), InputError);
  EXPECT_THROW(ViewGain(vision::Polytope{}, 0.05), InputError);
  EXPECT_THROW(ViewGain(rig_field(0.3, 0.3, -1, 3, 0), 0.05), InputError);
  EXPECT_THROW(ViewGain(rig_field(0.3, 0.3, 0.5, 3), 0.05, {1, 1}), InputError);
}

}  // namespace
}  // namespace headway::nav
