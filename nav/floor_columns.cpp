#include "nav/floor_columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::nav {
namespace {

using Index = VoxelMap::Index;

constexpr double kFloorBand = 0.1;  // [m], as far as voxels are not taller

LogOdds& voxel(ColdMap& map, const Index& i) {
  return map.edit({i.x() >> 3, i.y() >> 3,
                   i.z() >> 3})[static_cast<std::size_t>(in_brick(i.x() & 7, i.y() & 7, i.z() & 7))];
}

/// The cell (0, 0) among the columns of voxels. Throws InputError when the floor does not fit.
Eigen::Vector2i first_column(const FloorGrid& grid) {
  const Eigen::Array2d first = (grid.origin.array() / grid.resolution).round();
  const Eigen::Array2d end = first + Eigen::Array2d(grid.width, grid.height);
  constexpr double kReach = kBrickReach * kBrickEdge;
  if (!(first >= -kReach).all() || !(end <= kReach).all()) {
    throw InputError(
        fmt::format("floor: reaches beyond {} m from the origin, as far as a map may at this resolution",
                    kReach * grid.resolution));
  }
  return first.cast<int>();
}

/// Calls visit(voxel's Index, value) for each known voxel of layers [low, high).
template <class Visit>
void for_each_between(const ColdMap& map, int low, int high, Visit&& visit) {
  map.for_any([&](const BrickKey& key, const BrickValues& values) {
    const Index first = kBrickEdge * Index(key.x, key.y, key.z);
    if (first.z() >= high || first.z() + kBrickEdge <= low) return;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const LogOdds value = values[static_cast<std::size_t>(i)];
      if (value == log_odds::kUnseen) continue;
      const VoxelOfBrick in = voxel_of_brick(i);
      const Index at = first + Index(in.x, in.y, in.z);
      if (at.z() >= low && at.z() < high) visit(at, value);
    }
  });
}

}  // namespace

ColdMap raise_floor(const FloorMap& floor, double height, std::size_t most_bricks) {
  ColdMap map(floor.grid.resolution);
  const double top = std::round(height / floor.grid.resolution);
  if (!(top >= 1 && top <= kBrickReach * kBrickEdge)) {
    throw InputError(fmt::format("height: {} m, expected at least a voxel", height));
  }
  const Eigen::Vector2i first = first_column(floor.grid);
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      const Floor cell = floor.at({x, y});
      if (cell == Floor::kUnseen) continue;
      const Eigen::Vector2i column = first + Eigen::Vector2i(x, y);
      voxel(map, {column.x(), column.y(), -1}) = log_odds::kHighest;
      const LogOdds value = is_occupied(cell) ? log_odds::kHighest : log_odds::kLowest;
      for (int z = 0; z < static_cast<int>(top); ++z) voxel(map, {column.x(), column.y(), z}) = value;
      if (map.size() > most_bricks) {
        throw InputError(
            fmt::format("floor: needs more than {} bricks of 8 x 8 x 8 voxels, the most that one map may "
                        "have; choose a lower height",
                        most_bricks));
      }
    }
  }
  return map;
}

FloorMap floor_below(const ColdMap& map, const FloorMapConfig& config, double floor_height) {
  config.validate();
  const double r = map.resolution(), raised = std::round(floor_height / r), band = std::max(kFloorBand, r);
  if (!(std::abs(raised) <= kBrickReach * kBrickEdge)) {
    throw InputError(fmt::format("floor height: {} m lies outside of the map", floor_height));
  }
  const Index up(0, 0, static_cast<int>(raised));
  const int low = static_cast<int>(std::floor(-band / r)),
            high = static_cast<int>(std::ceil(config.body_height / r));
  Eigen::AlignedBox3i seen;
  for_each_between(map, up.z() + low, up.z() + high, [&](const Index& at, LogOdds) { seen.extend(at - up); });
  if (seen.isEmpty()) {
    throw InputError(
        fmt::format("floor map: nothing was seen between {} and {} m above the floor at z = {} m", low * r,
                    high * r, floor_height));
  }
  VoxelMapConfig box;
  box.resolution = r;
  box.floor_band = band;
  box.obstacle_height = std::max(config.body_height, band);
  box.lowest << seen.min().x() * r, seen.min().y() * r, low * r;
  box.highest << (seen.max().x() + 1) * r, (seen.max().y() + 1) * r, high * r;
  VoxelMap window(box);
  for_each_between(map, up.z() + low, up.z() + high, [&](const Index& at, LogOdds value) {
    const Index i = at - up - window.first_key();
    const std::size_t brick = window.brick_index({i.x() >> 3, i.y() >> 3, i.z() >> 3});
    window.edit(brick)[static_cast<std::size_t>(in_brick(i.x() & 7, i.y() & 7, i.z() & 7))] = value;
  });
  for (std::size_t b = 0; b < window.brick_count(); ++b) window.settle(b, Time{});
  return floor_map(window, config);
}

}  // namespace headway::nav
