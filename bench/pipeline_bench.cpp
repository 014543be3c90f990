// The stages of one frame at 640x480 on one core: look (rectify, match, triangulate), map, floor, plan. The
// pictures come from the simulated laboratory; the peer of the map stage is OctoMap's own insertion of the
// same points.
#include <stdexcept>
#include <vector>

#include <octomap/OcTree.h>
#include <opencv2/core/utility.hpp>

#include "app/robot_file.h"
#include "bench/figures.h"
#include "hal/angle.h"
#include "hal/clock.h"
#include "nav/floor_projection.h"
#include "nav/footsteps.h"
#include "nav/integrate.h"
#include "nav/planner.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_camera.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"
#include "vision/rig_files.h"
#include "vision/stereo.h"

namespace headway {
namespace {

const std::filesystem::path kTree = source_dir();

struct Look {
  hal::StereoFrame frame;
  Eigen::Isometry3d map_from_left;
};

/// Everything the stages need, made once.
struct Laboratory {
  app::Robot robot = app::read_robot(kTree / "config/hrp2/robot.yaml");
  vision::StereoRig rig = vision::read_rig(kTree / "config/hrp2/rigs/bottom_640.yaml");
  sim::World world = sim::read_world(kTree / "config/worlds/lab.yaml");
  vision::StereoVision vision{rig};
  std::vector<Look> looks;
  std::vector<vision::RangeView> views;
  nav::VoxelMap map{config()};
  nav::FloorMap floor;

  Laboratory() {
    cv::setNumThreads(1);
    render();
    nav::Integrator integrator;
    for (std::size_t i = 0; i < looks.size(); ++i) {
      views.push_back(vision.see(looks[i].frame));
      integrator.integrate(map, views[i], pose(i), Time{});
    }
    floor = nav::floor_map(map);
    nav::start_clear(floor, world.start, {}, Time{});
  }

  nav::VoxelMapConfig config() const {
    nav::VoxelMapConfig voxels = robot.mapper.voxels;
    const Eigen::Vector2d low = world.floor.centre - world.floor.size / 2,
                          high = world.floor.centre + world.floor.size / 2;
    voxels.lowest = {low.x() - 1, low.y() - 1, robot.map_height.x()};
    voxels.highest = {high.x() + 1, high.y() + 1, robot.map_height.y()};
    return voxels;
  }

  Eigen::Isometry3d pose(std::size_t look) const {
    return looks[look].map_from_left * vision.left_from_rectified();
  }

  void render() {
    const sim::Scene scene(world);
    hal::ManualClock clock;
    const auto lens = [](const vision::CameraIntrinsics& c) {
      return sim::Lens{c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3};
    };
    sim::StereoCameraModel model;
    model.left = lens(rig.left);
    model.right = lens(rig.right);
    model.right_from_left = rig.right_from_left;
    sim::SimStereoCamera camera(scene, clock, model);
    const Eigen::Isometry3d map_from_chest = world.start.lifted(robot.chest_height);
    for (const double pan : {-30.0, 0.0, 30.0})
      for (const double tilt : {0.0, 25.0, 40.0}) {
        const hal::HeadAngles head{pan * kDegree, tilt * kDegree};
        Look look;
        look.map_from_left = map_from_chest * robot.mission.neck.chest_from_camera(head);
        camera.expose(clock.now(), look.map_from_left);
        clock.advance(seconds(0.1));
        if (!camera.take_newest(look.frame)) throw std::runtime_error("the simulated camera gave no frame");
        looks.push_back(std::move(look));
      }
  }
};

Laboratory& laboratory() {
  static Laboratory lab;
  return lab;
}

void see(benchmark::State& state) {
  Laboratory& lab = laboratory();
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(lab.vision.see(lab.looks[i++ % lab.looks.size()].frame).depth.data());
}
BENCHMARK(see)->Unit(benchmark::kMillisecond);

void map(benchmark::State& state) {
  Laboratory& lab = laboratory();
  nav::VoxelMap voxels(lab.config());
  nav::Integrator integrator;
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t look = i++ % lab.looks.size();
    benchmark::DoNotOptimize(integrator.integrate(voxels, lab.views[look], lab.pose(look), Time{}).hits);
  }
}
BENCHMARK(map)->Unit(benchmark::kMillisecond);

/// The peer: the same points by OctoMap, in its quickest mode (lazy, discretized).
void map_octomap(benchmark::State& state) {
  Laboratory& lab = laboratory();
  octomap::OcTree tree(lab.robot.mapper.voxels.resolution);
  std::vector<octomap::Pointcloud> clouds(lab.looks.size());
  for (std::size_t look = 0; look < lab.looks.size(); ++look) {
    const vision::RangeView& view = lab.views[look];
    for (int v = 0; v < view.camera.height; ++v)
      for (int u = 0; u < view.camera.width; ++u) {
        const double z = static_cast<double>(view.depth[view.index(u, v)]);
        if (!(z <= view.far)) continue;
        const Eigen::Vector3f p = (lab.pose(look) * view.camera.point(u, v, z)).cast<float>();
        clouds[look].push_back(p.x(), p.y(), p.z());
      }
  }
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t look = i++ % lab.looks.size();
    const Eigen::Vector3f o = lab.pose(look).translation().cast<float>();
    tree.insertPointCloud(clouds[look], {o.x(), o.y(), o.z()}, -1, true, true);
  }
}
BENCHMARK(map_octomap)->Unit(benchmark::kMillisecond);

/// Of what a look has changed.
void floor(benchmark::State& state) {
  Laboratory& lab = laboratory();
  nav::VoxelMap voxels(lab.config());
  nav::Integrator integrator;
  nav::FloorMap floor = nav::unseen_floor(nav::floor_grid(voxels));
  nav::FloorProjection projection(floor.grid);
  std::size_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const std::size_t look = i++ % lab.looks.size();
    integrator.integrate(voxels, lab.views[look], lab.pose(look), Time{});
    state.ResumeTiming();
    projection.update(voxels, floor);
    benchmark::DoNotOptimize(floor.cells.data());
  }
}
BENCHMARK(floor)->Unit(benchmark::kMillisecond);

/// Of the whole map, as if all had changed.
void floor_anew(benchmark::State& state) {
  Laboratory& lab = laboratory();
  for (auto _ : state) benchmark::DoNotOptimize(nav::floor_map(lab.map).cells.data());
}
BENCHMARK(floor_anew)->Unit(benchmark::kMillisecond);

void plan(benchmark::State& state) {
  Laboratory& lab = laboratory();
  const auto& mission = lab.robot.mission;
  nav::Planner planner(mission.planner, mission.gait, mission.outline, lab.floor.grid);
  const nav::Goal goal{lab.world.goal->position, std::nullopt};
  for (auto _ : state) {
    const nav::PlanResult result = planner.plan(lab.floor, lab.world.start, goal);
    if (!result) {
      state.SkipWithError(nav::describe(result.reason));
      break;
    }
    const hal::Stance stance = hal::Stance::parallel(lab.world.start, mission.gait.feet_apart);
    benchmark::DoNotOptimize(
        nav::place_feet(result.path, stance, std::nullopt, lab.floor, mission.gait).steps.data());
  }
}
BENCHMARK(plan)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace headway

HEADWAY_BENCHMARK_MAIN()
