#include "nav/octree_leaves.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::nav {

LogOdds units_of(double log_odds, bool occupied) {
  const double units = std::clamp<double>(log_odds / log_odds::kUnit, log_odds::kLowest, log_odds::kHighest);
  const auto nearest = static_cast<LogOdds>(std::lround(units));
  return occupied ? std::max(nearest, log_odds::kOccupied)
                  : std::min(nearest, static_cast<LogOdds>(log_odds::kOccupied - 1));
}

OctreeLeaves::OctreeLeaves(double resolution, std::string source, std::size_t most_bricks)
    : map_(resolution), source_(std::move(source)), most_bricks_(most_bricks) {}

void OctreeLeaves::add(const OctreeCube& cube, LogOdds value) {
  const BrickKey first{cube.x / kBrickEdge - kBrickReach, cube.y / kBrickEdge - kBrickReach,
                       cube.z / kBrickEdge - kBrickReach};
  if (cube.edge < kBrickEdge) {
    BrickValues& values = brick(first);
    const int x0 = cube.x % kBrickEdge, y0 = cube.y % kBrickEdge, z0 = cube.z % kBrickEdge;
    for (int z = z0; z < z0 + cube.edge; ++z) {
      for (int y = y0; y < y0 + cube.edge; ++y) {
        for (int x = x0; x < x0 + cube.edge; ++x) values[static_cast<std::size_t>(in_brick(x, y, z))] = value;
      }
    }
    return;
  }
  const std::int32_t along = cube.edge / kBrickEdge;
  const auto n = static_cast<std::size_t>(along);
  make_room(n * n * n);
  for (std::int32_t z = 0; z < along; ++z) {
    for (std::int32_t y = 0; y < along; ++y) {
      for (std::int32_t x = 0; x < along; ++x) {
        map_.edit({first.x + x, first.y + y, first.z + z}).fill(value);
      }
    }
  }
}

BrickValues& OctreeLeaves::brick(const BrickKey& key) {
  if (last_ != nullptr && key == last_key_) return *last_;
  if (map_.find(key) == nullptr) make_room(1);
  last_ = &map_.edit(key);  // stays where it is while others come
  last_key_ = key;
  return *last_;
}

void OctreeLeaves::make_room(std::size_t bricks) const {
  if (map_.size() + bricks <= most_bricks_) return;
  throw InputError(
      fmt::format("{}: holds more than {} bricks of 8 x 8 x 8 voxels, the most that one map may have; cut a "
                  "smaller piece out of it, or make its voxels larger",
                  source_, most_bricks_));
}

}  // namespace headway::nav
