// Whether what a matcher makes of the edges of things stays out of the map.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "hal/clock.h"
#include "hal/head_kinematics.h"
#include "nav/integrate.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_camera.h"
#include "vision/stereo.h"

namespace headway {
namespace {

constexpr double kFocal = 540, kBaseline = 0.144;  // [px], [m]
constexpr int kWidth = 640, kHeight = 480;

vision::StereoRig rig() {
  vision::StereoRig rig;
  rig.name = "ideal";
  rig.left.fx = rig.left.fy = kFocal;
  rig.left.cx = (kWidth - 1) / 2.0;
  rig.left.cy = (kHeight - 1) / 2.0;
  rig.left.width = kWidth;
  rig.left.height = kHeight;
  rig.right = rig.left;
  rig.right_from_left.translation().x() = -kBaseline;
  return rig;
}

hal::StereoFrame taken(const sim::Scene& scene, const Eigen::Isometry3d& map_from_left) {
  sim::StereoCameraModel model;
  model.left = model.right =
      sim::Lens::pinhole(kWidth, kHeight, kFocal, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0);
  model.right_from_left.translation().x() = -kBaseline;
  hal::ManualClock clock;
  sim::SimStereoCamera camera(scene, clock, model);
  camera.expose(clock.now(), map_from_left);
  clock.advance(seconds(0.1));
  hal::StereoFrame frame;
  camera.take_newest(frame);
  return frame;
}

/// Distance [m] of a point from the surfaces of upright boxes and the floor; 0 inside of them.
double off_surfaces(const sim::Scene& scene, const Eigen::Vector3d& point) {
  double least = std::abs(point.z());
  for (const sim::Solid& s : scene.solids()) {
    const Eigen::Vector3d p = s.to_own(point).cwiseAbs();
    const Eigen::Vector3d half(s.length / 2, s.width / 2, (s.top - s.bottom) / 2);
    least = std::min(least, (p - half).cwiseMax(0).norm());
  }
  return least;
}

/// A room of 6 x 6 m with a bench in it, seen from (-2.4, 0).
sim::World room_with_bench(const Pose2& bench) {
  sim::World world;
  world.seed = 5;
  world.textures = {{.name = "wall", .brightness = 0.6}, {.name = "bench", .brightness = 0.35}};
  sim::add_room(world, {0, 0}, {6, 6}, 2.6, 0);
  sim::Solid solid = sim::Solid::box({0, 0, 0.45}, {0.6, 0.9, 0.9});
  solid.pose = bench;
  world.things.push_back({"bench", solid, 1});
  return world;
}

nav::VoxelMap mapped(const sim::Scene& scene) {
  nav::VoxelMapConfig box;
  box.lowest = {-3.2, -3.2, -0.4};
  box.highest = {3.2, 3.2, 2.4};
  nav::VoxelMap map(box);
  nav::Integrator integrator;
  vision::StereoVision stereo(rig());
  for (const double yaw : {-0.3, 0.0, 0.3})
    for (const double tilt : {0.1, 0.3, 0.5}) {
      Eigen::Isometry3d map_from_left = Pose2{-2.4, 0, yaw}.lifted(1.4);
      map_from_left.linear() *= hal::body_from_optical(tilt);
      integrator.integrate(map, stereo.see(taken(scene, map_from_left)), map_from_left, at_seconds(1));
    }
  return map;
}

/// Columns of the map with voxels that a robot's body would run into and that are farther than `apart` [m]
/// from all surfaces; and those where what stands nearer than that is occupied.
struct Columns {
  int off = 0, on = 0;
};
Columns count_columns(const nav::VoxelMap& map, const sim::Scene& scene, double apart) {
  Columns columns;
  const nav::VoxelMap::Index n = map.size();
  for (int x = 0; x < n.x(); ++x)
    for (int y = 0; y < n.y(); ++y) {
      bool off = false, on = false;
      for (int z = 0; z < n.z(); ++z) {
        const Eigen::Vector3d centre = map.centre({x, y, z});
        if (centre.z() < 0.1 || centre.z() > 1.7 || map.at({x, y, z}) != nav::Voxel::kOccupied) continue;
        (off_surfaces(scene, centre) > apart ? off : on) = true;
      }
      columns.off += off;
      columns.on += on;
    }
  return columns;
}

TEST(StereoMap, HangsNoVeilsBehindTheEdgesOfABench) {
  Columns all;
  for (const Pose2& bench : {Pose2{0.2, 0.6, 0}, Pose2{0.0, 0.2, 0.4}, Pose2{0.3, -0.3, -0.3},
                             Pose2{-0.3, 0.4, 0.8}, Pose2{0.5, -0.6, 0}}) {
    const sim::Scene scene(room_with_bench(bench));
    const Columns columns = count_columns(mapped(scene), scene, 0.125);
    all.off += columns.off;
    all.on += columns.on;
  }
  EXPECT_GE(all.on, 1000);
  EXPECT_LE(all.off, 0.005 * all.on);
}

}  // namespace
}  // namespace headway
