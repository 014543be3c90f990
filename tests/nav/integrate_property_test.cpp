// What holds for every view of every room.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "nav/integrate.h"
#include "room_map.h"
#include "synthetic_room.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
using Index = VoxelMap::Index;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

bool same_bytes(const VoxelMap& a, const VoxelMap& b) {
  for (std::size_t brick = 0; brick < a.brick_count(); ++brick) {
    if (!std::ranges::equal(a.values(brick), b.values(brick))) return false;
    if (a.summary(brick).changed != b.summary(brick).changed) return false;
  }
  return true;
}

// A random view of a room with random boxes, at ranges that reduce the image by 1, 2 or 4; its errors stay
// within three sigma.
struct Scenario {
  SyntheticRoom room;
  VoxelMap map;
  Isometry3d pose;
  vision::RangeView view;
};

double between(double lowest, double highest) {
  return lowest + (highest - lowest) * *rc::gen::inRange(0, 1 << 20) / static_cast<double>(1 << 20);
}

Scenario any_scenario() {
  SyntheticRoom room;
  const int boxes = *rc::gen::inRange(0, 5);
  for (int b = 0; b < boxes; ++b) {
    const Vector3d corner(between(-2.5, 2), between(-2.3, 2), between(0, 2));
    room.solids.push_back(
        {corner, corner + Vector3d(between(0.02, 0.8), between(0.02, 0.8), between(0.02, 1.5))});
  }
  Vector3d eye(0, 0, 1.3);
  do {
    eye = {between(-2.4, 2.4), between(-2.2, 2.2), between(0.3, 2.2)};
  } while (room.clearance(eye) < 0.1);
  const Isometry3d pose = camera_pose(eye, between(-3.1, 3.1), between(-0.7, 0.9)) *
                          Eigen::AngleAxisd(between(-0.3, 0.3), Vector3d::UnitZ());
  const double far = *rc::gen::element(2.5, 5.0);
  const double sigma = *rc::gen::element(0.1, 0.3);
  Noise noise;
  noise.disparity_sigma = *rc::gen::element(0.0, sigma);
  noise.largest = 2.9;
  noise.correlation = *rc::gen::inRange(1, 5);
  noise.seed = *rc::gen::arbitrary<std::uint64_t>();
  return {room, room_map(*rc::gen::element(0.05, 0.04)), pose,
          look(room, camera_of(120, 160, 33 * kDegree), pose, noise, sigma, 0.5, far)};
}

/// The pixels that a voxel may project to, widened by `margin`; nothing when it reaches behind the camera.
struct Footprint {
  int u0 = 0, v0 = 0, u1 = -1, v1 = -1;
  double nearest = 0;
  bool whole = false;  ///< before the camera
};

Footprint footprint(const Scenario& s, const Index& i, int margin) {
  const auto& camera = s.view.camera;
  const Isometry3d camera_from_map = s.pose.inverse();
  double u0 = 1e9, v0 = 1e9, u1 = -1e9, v1 = -1e9, nearest = 1e9;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d offset((corner & 1) - 0.5, (corner >> 1 & 1) - 0.5, (corner >> 2 & 1) - 0.5);
    const Vector3d c = camera_from_map * (s.map.centre(i) + offset * s.map.resolution());
    if (c.z() <= 0.05) return {};
    const double u = camera.focal * c.x() / c.z() + camera.cx, v = camera.focal * c.y() / c.z() + camera.cy;
    u0 = std::min(u0, u), u1 = std::max(u1, u), v0 = std::min(v0, v), v1 = std::max(v1, v);
    nearest = std::min(nearest, c.z());
  }
  const auto clamped = [](double x, int size) { return static_cast<int>(std::clamp(x, 0.0, size - 1.0)); };
  return {clamped(u0 - margin, camera.width),
          clamped(v0 - margin, camera.height),
          clamped(u1 + margin, camera.width),
          clamped(v1 + margin, camera.height),
          nearest,
          true};
}

RC_GTEST_PROP(Integrate, TakesPointsOfLittleWeightForUnmeasured, ()) {
  Scenario s = any_scenario();
  const IntegrationConfig config;
  vision::RangeView without = s.view;
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  s.view.weight.assign(s.view.depth.size(), 1);
  for (std::size_t i = 0; i < s.view.depth.size(); ++i) {
    if (std::isnan(s.view.depth[i])) {
      s.view.weight[i] = kNan;
    } else if (random() % 4 == 0) {
      s.view.weight[i] = static_cast<float>(config.least_weight) - 0.01F;
      without.depth[i] = without.sigma_depth[i] = kNan;
    } else {
      s.view.weight[i] = static_cast<float>(config.least_weight) + 0.01F;
    }
  }
  VoxelMap other = s.map;
  integrate(s.map, s.view, s.pose, at_seconds(1), config);
  integrate(other, without, s.pose, at_seconds(1), config);
  RC_ASSERT(same_bytes(s.map, other));
}

RC_GTEST_PROP(Integrate, ChangesNoVoxelFartherThanRangePlusThreeSigmaPlusAVoxel, ()) {
  Scenario s = any_scenario();
  integrate(s.map, s.view, s.pose, at_seconds(1));
  for_each_known(s.map, [&](const Index& i) {
    const Footprint f = footprint(s, i, 8);
    RC_ASSERT(f.whole);
    double reach = 0;
    for (int v = f.v0; v <= f.v1; ++v) {
      for (int u = f.u0; u <= f.u1; ++u) {
        const double z = static_cast<double>(s.view.depth[s.view.index(u, v)]);
        const double sigma = static_cast<double>(s.view.sigma_depth[s.view.index(u, v)]);
        if (z > 0) reach = std::max(reach, z + 3 * sigma + s.map.resolution());
      }
    }
    RC_ASSERT(f.nearest <= reach);
    RC_ASSERT(f.nearest <= s.view.far);
  });
}

RC_GTEST_PROP(Integrate, LeavesWhatPixelsWithoutDepthWouldShow, ()) {
  Scenario s = any_scenario();
  const int u0 = *rc::gen::inRange(0, 100), v0 = *rc::gen::inRange(0, 140);
  const int u1 = *rc::gen::inRange(u0, 120), v1 = *rc::gen::inRange(v0, 160);
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u)
      s.view.depth[s.view.index(u, v)] = s.view.sigma_depth[s.view.index(u, v)] = kNan;
  }
  integrate(s.map, s.view, s.pose, at_seconds(1));
  for_each_known(s.map, [&](const Index& i) {
    const Footprint f = footprint(s, i, 4);
    RC_ASSERT(f.u0 < u0 || f.u1 > u1 || f.v0 < v0 || f.v1 > v1);
  });
}

RC_GTEST_PROP(Integrate, EmptiesNothingThatIsSolid, ()) {
  Scenario s = any_scenario();
  integrate(s.map, s.view, s.pose, at_seconds(1));
  for_each_known(s.map, [&](const Index& i) {
    if (s.map.at(i) == Voxel::kEmpty)
      RC_ASSERT(s.room.clearance(s.map.centre(i)) > -1.001 * s.map.resolution());
  });
}

RC_GTEST_PROP(Integrate, GivesTheSameBytesForTheSameViewsWhateverCameBeforeInItsMemory, ()) {
  const Scenario a = any_scenario(), b = any_scenario();
  VoxelMap once = room_map(), again = room_map();
  integrate(once, a.view, a.pose, at_seconds(1));
  integrate(once, b.view, b.pose, at_seconds(2));
  Integrator used;
  VoxelMap other = room_map(0.1);
  used.integrate(other, b.view, b.pose, at_seconds(0));
  used.integrate(again, a.view, a.pose, at_seconds(1));
  used.integrate(again, b.view, b.pose, at_seconds(2));
  RC_ASSERT(same_bytes(once, again));
}

RC_GTEST_PROP(Integrate, CountsWhatItDid, ()) {
  Scenario s = any_scenario();
  const IntegrationStats stats = integrate(s.map, s.view, s.pose, at_seconds(1));
  std::size_t occupied = 0, empty = 0, bricks = 0;
  for_each_known(s.map, [&](const Index& i) { (s.map.at(i) == Voxel::kOccupied ? occupied : empty) += 1; });
  for (std::size_t b = 0; b < s.map.brick_count(); ++b) bricks += s.map.summary(b).changed == at_seconds(1);
  RC_ASSERT(stats.hits == occupied);
  RC_ASSERT(stats.misses == empty);
  RC_ASSERT(stats.first_seen == occupied + empty);
  RC_ASSERT(stats.bricks_changed == bricks);
}

}  // namespace
}  // namespace headway::nav
