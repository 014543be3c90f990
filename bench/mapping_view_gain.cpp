// How quickly the worth of a look is worked out, against the same question asked of OctoMap ray by ray. One
// core.
#include <cmath>
#include <numbers>
#include <vector>

#include <benchmark/benchmark.h>
#include <octomap/OcTree.h>

#include "bench/cpu_time.h"
#include "hal/head_kinematics.h"
#include "nav/integrate.h"
#include "nav/octomap_files.h"
#include "nav/view_gain.h"
#include "sim_hal/render.h"
#include "sim_hal/scene.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"

namespace headway::bench {

namespace {

constexpr double kNear = 0.4, kFar = 5.0;
constexpr int kWidth = 640, kHeight = 480;
const double kTangent = std::tan(std::numbers::pi / 6);  // 60 deg across

Eigen::Isometry3d pose(const Eigen::Vector3d& eye, double yaw, double down) {
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  map_from_camera.linear() =
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * hal::body_from_optical(down);
  map_from_camera.translation() = eye;
  return map_from_camera;
}

/// What a camera 60 deg wide shows from kNear to kFar.
vision::Polytope field() {
  const double across = kTangent, down = kTangent * kHeight / kWidth;
  std::vector<Eigen::Vector4d> rows;
  for (const Eigen::Vector4d& row :
       {Eigen::Vector4d(1, 0, across, 0), Eigen::Vector4d(-1, 0, across, 0), Eigen::Vector4d(0, 1, down, 0),
        Eigen::Vector4d(0, -1, down, 0), Eigen::Vector4d(0, 0, 1, -kNear), Eigen::Vector4d(0, 0, -1, kFar)})
    rows.push_back(vision::half_space(row));
  return *vision::minimal_polytope(rows);
}

vision::RangeView look(const sim::Scene& scene, const Eigen::Isometry3d& map_from_camera) {
  vision::RangeView view;
  const double focal = kWidth / 2.0 / kTangent;
  view.camera = {kWidth, kHeight, focal, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0};
  view.near = kNear;
  view.far = kFar;
  const sim::Lens lens = sim::Lens::pinhole(kWidth, kHeight, focal, view.camera.cx, view.camera.cy);
  view.depth = sim::true_depth(scene, sim::ray_table(lens), map_from_camera);
  for (const float z : view.depth) view.sigma_depth.push_back(0.002F * z * z);
  return view;
}

/// The laboratory, seen from the start in four directions at this resolution, and looks that could come next.
struct Laboratory {
  sim::Scene scene{sim::read_world(source_dir() / "config/worlds/lab.yaml")};
  nav::VoxelMap map;
  std::vector<Eigen::Isometry3d> candidates;

  explicit Laboratory(double resolution) : map(box(resolution)) {
    nav::Integrator integrator;
    for (const double yaw : {-0.6, 0.0, 0.6, 1.2}) {
      const Eigen::Isometry3d from = pose({-2.6, -1.6, 1.37}, yaw, 0.35);
      integrator.integrate(map, look(scene, from), from, Time{});
    }
    for (const Eigen::Vector3d& eye : {Eigen::Vector3d(-2.6, -1.6, 1.37), Eigen::Vector3d(-1.2, 0.2, 1.37),
                                       Eigen::Vector3d(0.4, 0.3, 1.37)})
      for (const double down : {0.0, 0.5})
        for (double yaw = -2.8; yaw < 3; yaw += 0.7) candidates.push_back(pose(eye, yaw, down));
  }
  static nav::VoxelMapConfig box(double resolution) {
    nav::VoxelMapConfig config;
    config.resolution = resolution;
    config.lowest = {-4.6, -4.1, -0.4};
    config.highest = {4.6, 4.1, 2.4};
    return config;
  }
};

/// The same by 80 x 60 rays of OctoMap's, within the box of `map`.
std::size_t octomap_gain(const octomap::OcTree& tree, const nav::VoxelMap& map,
                         const Eigen::Isometry3d& map_from_camera) {
  octomap::KeyRay keys;
  octomap::KeySet unseen;
  const auto point = [](const Eigen::Vector3d& p) {
    return octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  };
  const auto in_map = [&](const octomap::OcTreeKey& key) {
    const octomap::point3d p = tree.keyToCoord(key);
    return map.contains(map.index(Eigen::Vector3d(p.x(), p.y(), p.z())));
  };
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 80; ++u) {
      const Eigen::Vector3d ray((u - 39.5) / 40 * kTangent, (v - 29.5) / 40 * kTangent, 1);
      tree.computeRayKeys(point(map_from_camera * Eigen::Vector3d(kNear * ray)),
                          point(map_from_camera * Eigen::Vector3d(kFar * ray)), keys);
      for (const octomap::OcTreeKey& key : keys) {
        if (!in_map(key)) continue;
        const octomap::OcTreeNode* node = tree.search(key);
        if (!node)
          unseen.insert(key);
        else if (tree.isNodeOccupied(node))
          break;
      }
    }
  return unseen.size();
}

/// gain_ms_NN: processor time for the gain of one look 60 deg wide, mean over looks into the laboratory half
/// seen.
void view_gain(benchmark::State& state, double resolution) {
  const Laboratory lab(resolution);
  nav::ViewGain gain(field(), resolution);
  std::size_t sum = 0;
  const double before = cpu_seconds();
  for (auto _ : state)
    for (const Eigen::Isometry3d& candidate : lab.candidates)
      benchmark::DoNotOptimize(sum += gain.gain(lab.map, candidate));
  const double looks = static_cast<double>(state.iterations()) * static_cast<double>(lab.candidates.size());
  state.counters["gain_ms_" + std::to_string(std::lround(100 * resolution)) + "cm"] =
      1e3 * (cpu_seconds() - before) / looks;
}
BENCHMARK_CAPTURE(view_gain, 5cm, 0.05)->MinTime(0.5)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(view_gain, 2cm, 0.02)->MinTime(0.5)->Unit(benchmark::kMillisecond);

/// octomap_gain_ms_5cm: the same by OctoMap's ray keys and searches, and gain_over_octomap, what we count
/// over what its rays do (all heights; near the camera several rays pass one voxel, far away they miss some).
void view_gain_octomap(benchmark::State& state) {
  const Laboratory lab(0.05);
  const auto tree = nav::to_octree(lab.map);
  nav::ViewGain gain(field(), 0.05, {-10, 10});
  double ours = 0, theirs = 0;
  const double before = cpu_seconds();
  for (auto _ : state)
    for (const Eigen::Isometry3d& candidate : lab.candidates)
      theirs += static_cast<double>(octomap_gain(*tree, lab.map, candidate));
  const double looks = static_cast<double>(state.iterations()) * static_cast<double>(lab.candidates.size());
  state.counters["octomap_gain_ms_5cm"] = 1e3 * (cpu_seconds() - before) / looks;
  for (const Eigen::Isometry3d& candidate : lab.candidates)
    ours += static_cast<double>(gain.gain(lab.map, candidate));
  state.counters["gain_over_octomap"] = ours * static_cast<double>(state.iterations()) / theirs;
}
BENCHMARK(view_gain_octomap)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace headway::bench
