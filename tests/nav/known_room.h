// A room that has been looked at from known places: its map, its surfaces, and views from elsewhere.
#pragma once

#include <numbers>
#include <utility>
#include <vector>

#include "nav/integrate.h"
#include "nav/localise.h"
#include "synthetic_room.h"

namespace headway::nav {

/// As a map file of version 2 keeps them.
inline SurfacePoints without_rays(const SurfacePoints& surfaces) {
  SurfacePoints old(surfaces.resolution());
  for (SurfaceVoxel voxel : surfaces.saved()) {
    voxel.rays = {};
    old.restore(voxel);
  }
  return old;
}

struct KnownRoom {
  explicit KnownRoom(SyntheticRoom room_) : room(std::move(room_)) {}

  vision::RangeView see(const Eigen::Isometry3d& pose, std::uint64_t seed) const {
    const Noise noise{.disparity_sigma = 0.1, .correlation = 2, .outliers = 0.002, .seed = seed};
    return look(room, camera, pose, noise, 0.1, 0.6, 6.0);
  }
  void learn(const Eigen::Isometry3d& pose, std::uint64_t seed, const PoseVariance& variance = {}) {
    const vision::RangeView view = see(pose, seed);
    integrator.integrate(map, view, pose, Time{});
    view_patches(view, {}, patches);
    surfaces.add(patches, pose, map, variance);
  }
  /// From `eye` in all directions between two headings, three looks each.
  void look_around(const Eigen::Vector3d& eye, std::uint64_t seed, double first = -std::numbers::pi,
                   double last = std::numbers::pi) {
    for (double yaw = first; yaw < last; yaw += 0.45)
      for (const double down : {0.1, 0.6})
        for (int look = 0; look < 3; ++look) learn(camera_pose(eye, yaw, down), ++seed);
  }
  /// The view from `pose`, aligned from where it is believed to come from: moved back by `change`.
  Alignment align(const Eigen::Isometry3d& pose, const Eigen::Vector3d& change, std::uint64_t seed,
                  const Eigen::Vector3d& sigma) {
    view_patches(see(pose, seed), {}, patches);
    Eigen::Isometry3d believed = pose;
    believed.linear() =
        Eigen::AngleAxisd(-change.z(), Eigen::Vector3d::UnitZ()).toRotationMatrix() * pose.linear();
    believed.translation() -= Eigen::Vector3d(change.x(), change.y(), 0);
    return localiser.align(map, surfaces, patches, believed, believed.translation().head<2>(),
                           sigma.cwiseAbs2().asDiagonal());
  }

  static VoxelMapConfig box() {
    VoxelMapConfig config;
    config.lowest = {-4.4, -4.4, -0.4};
    config.highest = {4.4, 4.4, 2.8};
    return config;
  }

  SyntheticRoom room;
  vision::PinholeCamera camera = camera_of(170, 240, 33 * std::numbers::pi / 180);
  VoxelMap map{box()};
  SurfacePoints surfaces{map.resolution()};
  Integrator integrator;
  Localiser localiser;
  std::vector<Patch> patches;
};

/// A room with walls and boxes at random places.
inline SyntheticRoom random_room(std::mt19937_64& random) {
  const auto between = [&](double a, double b) { return a + (b - a) * uniform(random); };
  SyntheticRoom room;
  room.walls = {{between(-3, -2.4), between(-3, -2.4), 0}, {between(2.4, 3), between(2.4, 3), 2.5}};
  for (int i = 0; i < 5; ++i) {
    const double heading = between(-3.1, 3.1), away = between(1.3, 2);
    const Eigen::Vector3d foot(away * std::cos(heading), away * std::sin(heading), 0);
    room.solids.push_back({foot - Eigen::Vector3d(between(0.1, 0.3), between(0.1, 0.3), 0),
                           foot + Eigen::Vector3d(between(0.1, 0.3), between(0.1, 0.3), between(0.4, 2))});
  }
  return room;
}

}  // namespace headway::nav
