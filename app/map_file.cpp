#include "app/map_file.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "hal/error.h"
#include "nav/cold_map.h"
#include "nav/cold_map_file.h"
#include "nav/octomap_files.h"

namespace headway::app {

namespace {

namespace fs = std::filesystem;

nav::ColdMap read_any(const fs::path& file) {
  if (file.extension() == ".hmap") return nav::read_map_file(file);
  if (file.extension() == ".bt") return nav::read_bt(file);
  if (file.extension() == ".ot") return nav::read_ot(file);
  throw InputError(
      fmt::format("{}: has an unknown ending, expected a map (.hmap, .bt or .ot)", file.string()));
}

Eigen::Vector3i place_of(const nav::BrickKey& key) { return {key.x, key.y, key.z}; }

nav::VoxelMap box_around(const nav::ColdMap& known, nav::VoxelMapConfig config, const fs::path& file) {
  if (known.size() == 0) throw InputError(fmt::format("{}: knows nothing, expected a map", file.string()));
  config.resolution = known.resolution();
  Eigen::Vector3i first = Eigen::Vector3i::Constant(std::numeric_limits<int>::max()), last = -first;
  known.for_any([&](const nav::BrickKey& key, const nav::BrickValues&) {
    first = first.cwiseMin(place_of(key));
    last = last.cwiseMax(place_of(key));
  });
  const double brick = config.resolution * nav::VoxelMap::kBrickEdge;
  config.lowest = config.lowest.cwiseMin(brick * first.cast<double>());
  config.highest = config.highest.cwiseMax(brick * (last.array() + 1).cast<double>().matrix());
  try {
    return nav::VoxelMap(config);
  } catch (const InputError& fault) {
    throw InputError(fmt::format("{}: {}", file.string(), fault.what()));
  }
}

}  // namespace

nav::VoxelMap read_map(const fs::path& file, const nav::VoxelMapConfig& like) {
  const nav::ColdMap known = read_any(file);
  nav::VoxelMap map = box_around(known, like, file);
  const Eigen::Vector3i first = map.first_key() / nav::VoxelMap::kBrickEdge;
  known.for_any([&](const nav::BrickKey& key, const nav::BrickValues& values) {
    const std::size_t brick = map.brick_index(place_of(key) - first);
    std::copy(values.begin(), values.end(), map.edit(brick).begin());
    map.settle(brick, Time{});
  });
  return map;
}

}  // namespace headway::app
