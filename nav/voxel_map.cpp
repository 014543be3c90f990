#include "nav/voxel_map.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "hal/error.h"

namespace headway::nav {
namespace {

constexpr double kMostVoxels = 3e8;      // bytes, too; the floor map and the planner need as much again
constexpr double kKeyReach = 32768 - 8;  // OctoMap's keys are 16 bits wide

[[noreturn]] void refuse(const std::string& what) { throw InputError("voxel map: " + what); }

std::string text(const Eigen::Vector3d& v) {
  std::ostringstream out;
  out << '(' << v.x() << ", " << v.y() << ", " << v.z() << ')';
  return out.str();
}

/// Whole bricks from the map's origin; a corner that lies on a brick's boundary but for rounding counts as on
/// it.
Eigen::Vector3d bricks_below(const Eigen::Vector3d& corner, double brick) {
  return (corner.array() / brick + 1e-6).floor();
}
Eigen::Vector3d bricks_above(const Eigen::Vector3d& corner, double brick) {
  return (corner.array() / brick - 1e-6).ceil();
}

}  // namespace

void VoxelMapConfig::validate() const {
  if (!(resolution >= 0.005 && resolution <= 1.0)) {
    refuse("resolution: " + std::to_string(resolution) + " m, expected 0.005 to 1 m");
  }
  if (!lowest.allFinite() || !highest.allFinite() || !(lowest.array() < highest.array()).all()) {
    refuse("the corners " + text(lowest) + " and " + text(highest) +
           " enclose no box; the lowest must lie below the highest in x, y and z");
  }
  const double brick = resolution * VoxelMap::kBrickEdge;
  const Eigen::Vector3d first = bricks_below(lowest, brick), end = bricks_above(highest, brick);
  if ((first.array() * 8 < -kKeyReach).any() || (end.array() * 8 > kKeyReach).any()) {
    refuse("the box " + text(lowest) + " to " + text(highest) + " reaches beyond OctoMap's keys (" +
           std::to_string(kKeyReach * resolution) + " m from the origin at this resolution)");
  }
  if (((end - first) * 8).prod() > kMostVoxels) {
    refuse("the box " + text(lowest) + " to " + text(highest) +
           " holds more than 3e8 voxels at this resolution; make it smaller or the voxels larger");
  }
  if (!(floor_band > 0 && floor_band <= 1)) {
    refuse("floor band: " + std::to_string(floor_band) + " m, expected more than 0 and at most 1 m");
  }
  if (!(obstacle_height >= floor_band && obstacle_height <= 10)) {
    refuse("obstacle height: " + std::to_string(obstacle_height) +
           " m, expected at most 10 m and no less than the "
           "floor band");
  }
}

VoxelMap::VoxelMap(const VoxelMapConfig& config) : config_(config) {
  config.validate();
  const double brick = config.resolution * kBrickEdge;
  const Index first = bricks_below(config.lowest, brick).cast<int>();
  bricks_ = bricks_above(config.highest, brick).cast<int>() - first;
  first_key_ = kBrickEdge * first;
  const auto count = static_cast<std::size_t>(bricks_.x()) * static_cast<std::size_t>(bricks_.y()) *
                     static_cast<std::size_t>(bricks_.z());
  values_.assign(count * kBrickVoxels, log_odds::kUnseen);
  summaries_.assign(count, {});
  floor_seen_.assign(static_cast<std::size_t>(size().x()) * static_cast<std::size_t>(size().y()), kNever);
  const auto in_band = [&](int z) { return std::abs(centre({0, 0, z}).z()) <= config.floor_band; };
  while (foot_begin_ < size().z() && !in_band(foot_begin_)) ++foot_begin_;
  foot_end_ = foot_begin_;
  while (foot_end_ < size().z() && in_band(foot_end_)) ++foot_end_;
}

void VoxelMap::set(const Index& i, LogOdds value, Time stamp) {
  values_[offset(i)] = value;
  settle(offset(i) / kBrickVoxels, stamp);
}

VoxelMap::Index VoxelMap::brick_at(std::size_t brick) const {
  const auto nx = static_cast<std::size_t>(bricks_.x()), ny = static_cast<std::size_t>(bricks_.y());
  return {static_cast<int>(brick % nx), static_cast<int>(brick / nx % ny),
          static_cast<int>(brick / (nx * ny))};
}

void VoxelMap::settle(std::size_t brick, Time stamp) {
  unsigned unseen = 0, occupied = 0;
  for (const LogOdds v : values(brick)) {
    unseen += v == log_odds::kUnseen;
    occupied += v >= log_odds::kOccupied;
  }
  summaries_[brick] = {static_cast<std::uint16_t>(unseen), static_cast<std::uint16_t>(occupied), stamp};
}

Time VoxelMap::floor_seen_at(int x, int y) const {
  const Index n = size();
  return x >= 0 && y >= 0 && x < n.x() && y < n.y() ? floor_seen_[column(x, y)] : kNever;
}

}  // namespace headway::nav
