// How long a map of 3.7 million voxels takes to become a .bt file, straight from its bricks and as OctoMap's
// own library writes it from a tree, in one run.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <octomap/OcTree.h>

#include "bench/cpu_time.h"
#include "bench/figures.h"
#include "nav/octomap_files.h"
#include "tests/temporary_folder.h"

namespace headway {
namespace {

constexpr double kVoxels = 3.7e6;

/// What nine views of a room leave: walls, floor and ceiling a few voxels thick, spheres standing in it,
/// empty space between, and unseen space in their shadows; as rough as noise makes it.
nav::ColdMap room_of(double resolution) {
  nav::ColdMap map(resolution);
  const auto reach = static_cast<std::int32_t>(std::ceil(2.8 / (8 * resolution)));
  std::uint32_t noise = 1;
  for (std::int32_t bz = -1; bz < reach; ++bz) {
    for (std::int32_t by = -reach; by < reach; ++by) {
      for (std::int32_t bx = -reach; bx < reach; ++bx) {
        nav::BrickValues values;
        for (int i = 0; i < nav::kBrickVoxels; ++i) {
          const nav::VoxelOfBrick in = nav::voxel_of_brick(i);
          noise = noise * 1664525 + 1013904223;
          const double rough = 2 * resolution * (noise >> 8) / (1 << 24);
          const double x = (8 * bx + in.x + 0.5) * resolution, y = (8 * by + in.y + 0.5) * resolution,
                       z = (8 * bz + in.z + 0.5) * resolution;
          const double sphere = std::hypot(x - std::round(x), y - std::round(y), z - 0.5) - 0.3;
          const double wall = std::min({2.6 - std::abs(x), 2.6 - std::abs(y), 2.6 - z, z, sphere});
          const bool shadow =
              wall < -2 * resolution || (std::abs(x - std::round(x)) < 0.1 && z > 0.8 && z < 1.2);
          const int value = shadow         ? nav::log_odds::kUnseen
                            : wall < rough ? 17 + static_cast<int>(noise >> 27)
                                           : -8;
          values[static_cast<std::size_t>(i)] = static_cast<nav::LogOdds>(value);
        }
        map.put({bx, by, bz}, values);
      }
    }
  }
  return map;
}

double known_voxels(const nav::ColdMap& map) {
  std::ptrdiff_t count = 0;
  map.for_any([&](const nav::BrickKey&, const nav::BrickValues& values) {
    count += nav::kBrickVoxels - std::count(values.begin(), values.end(), nav::log_odds::kUnseen);
  });
  return static_cast<double>(count);
}

/// The room at a resolution that gives no fewer voxels.
nav::ColdMap room_with(double voxels) {
  double resolution = 0.05;
  nav::ColdMap map = room_of(resolution);
  while (known_voxels(map) < voxels) map = room_of(resolution *= 0.98);
  return map;
}

/// The tree that OctoMap's library makes of the map, voxel by voxel.
octomap::OcTree tree_of(const nav::ColdMap& map) {
  octomap::OcTree tree(map.resolution());
  map.for_each([&](const nav::BrickKey& key, const auto& values) {
    for (int i = 0; i < nav::kBrickVoxels; ++i) {
      const nav::LogOdds value = values[static_cast<std::size_t>(i)];
      if (value == nav::log_odds::kUnseen) continue;
      const nav::VoxelOfBrick in = nav::voxel_of_brick(i);
      const auto along = [](std::int32_t k, int v) {
        return static_cast<octomap::key_type>(8 * k + v + 32768);
      };
      const octomap::OcTreeKey voxel(along(key.x, in.x), along(key.y, in.y), along(key.z, in.z));
      tree.setNodeValue(voxel, static_cast<float>(value * nav::log_odds::kUnit), true);
    }
  });
  tree.updateInnerOccupancy();
  return tree;
}

std::string data_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(in), {}};
  return all.substr(all.find("\ndata\n"));
}

void bt_write_wall(benchmark::State& state) {
  const nav::ColdMap map = room_with(kVoxels);
  const TemporaryFolder folder;
  bench::LeastTime ours, theirs;
  theirs.take([&] { tree_of(map).writeBinary((folder / "theirs.bt").string()); });
  for (auto _ : state) ours.take([&] { nav::write_bt(map, folder / "ours.bt"); });
  if (data_of(folder / "ours.bt") != data_of(folder / "theirs.bt"))
    state.SkipWithError("OctoMap writes other bytes");
  bench::figure("bt_voxels", known_voxels(map));
  bench::figure("bt_write_ms", 1e3 * ours.seconds());
  bench::figure("octomap_bt_write_ms", 1e3 * theirs.seconds());
}
BENCHMARK(bt_write_wall)->Unit(benchmark::kMillisecond)->Iterations(50);

}  // namespace
}  // namespace headway
