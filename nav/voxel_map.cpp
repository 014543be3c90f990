#include "nav/voxel_map.h"

#include <algorithm>
#include <bit>
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

BrickRange bricks_in(const VoxelMapConfig& config) {
  const double brick = config.resolution * kBrickEdge;
  return {bricks_below(config.lowest, brick).cast<int>(), bricks_above(config.highest, brick).cast<int>()};
}

VoxelMap::VoxelMap(const VoxelMapConfig& config) : config_(config) {
  config.validate();
  const BrickRange box = bricks_in(config);
  bricks_ = box.end - box.first;
  first_key_ = kBrickEdge * box.first;
  const auto count = static_cast<std::size_t>(bricks_.x()) * static_cast<std::size_t>(bricks_.y()) *
                     static_cast<std::size_t>(bricks_.z());
  values_.assign(count * kBrickVoxels, log_odds::kUnseen);
  summaries_.assign(count, {});
  emptied_.assign(count, 0);
  floor_seen_.assign(static_cast<std::size_t>(size().x()) * static_cast<std::size_t>(size().y()), kNever);
  column_changed_.assign(static_cast<std::size_t>(bricks_.x()) * static_cast<std::size_t>(bricks_.y()), 0);
  find_foot();
}

std::size_t VoxelMap::bytes() const {
  return sizeof *this + values_.size() + summaries_.size() * sizeof(BrickSummary) + emptied_.size() +
         floor_seen_.size() * sizeof(Time) + column_changed_.size() * sizeof(std::uint64_t);
}

void VoxelMap::find_foot() {
  const auto in_band = [&](int z) { return std::abs(centre({0, 0, z}).z()) <= config_.floor_band; };
  foot_begin_ = 0;
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
  const Index on_torus(static_cast<int>(brick % nx), static_cast<int>(brick / nx % ny),
                       static_cast<int>(brick / (nx * ny)));
  const Eigen::Array3i at = (on_torus - turned_).array();
  return (at < 0).select(at + bricks_.array(), at);
}

void VoxelMap::settle(std::size_t brick, Time stamp) {
  unsigned unseen = 0, occupied = 0;
  for (const LogOdds v : values(brick)) {
    unseen += v == log_odds::kUnseen;
    occupied += v >= log_odds::kOccupied;
  }
  summaries_[brick] = {static_cast<std::uint16_t>(unseen), static_cast<std::uint16_t>(occupied), stamp};
  emptied_[brick] = 0;
  note_change(brick % column_changed_.size());
}

void VoxelMap::roll_to(const Eigen::Vector3d& centre, BrickStore* store) {
  const double brick = config_.resolution * kBrickEdge;
  const Eigen::Array3d n = bricks_.cast<double>(), reach = Eigen::Array3d::Constant(kKeyReach / kBrickEdge);
  const Index first = (centre.array() / brick - n / 2 + 0.5).floor().max(-reach).min(reach - n).cast<int>();
  const Index shift = first - first_key_ / kBrickEdge;
  if (shift.isZero()) return;
  for_each_outside(-shift, [&](const Index& at) { leave(at, store); });
  first_key_ = kBrickEdge * first;
  for (int axis = 0; axis < 3; ++axis) {
    const int size = bricks_[axis];
    turned_[axis] = ((turned_[axis] + shift[axis]) % size + size) % size;
  }
  find_foot();
  for_each_outside(shift, [&](const Index& at) { enter(at, store); });
}

template <class Visit>
void VoxelMap::for_each_outside(const Index& shift, const Visit& visit) const {
  const auto inside = [&](int at, int axis) {
    return at + shift[axis] >= 0 && at + shift[axis] < bricks_[axis];
  };
  for (int z = 0; z < bricks_.z(); ++z)
    for (int y = 0; y < bricks_.y(); ++y)
      for (int x = 0; x < bricks_.x(); ++x)
        if (!(inside(x, 0) && inside(y, 1) && inside(z, 2))) visit(Index(x, y, z));
}

void VoxelMap::leave(const Index& at, BrickStore* store) {
  const std::size_t brick = brick_index(at);
  emptied_[brick] = 0;
  std::fill_n(floor_seen_.begin() + static_cast<std::ptrdiff_t>(columns_of(at)), kColumns, kNever);
  if (summaries_[brick].unseen == kBrickVoxels) return;
  if (store != nullptr) store->keep(key(at), values(brick), summaries_[brick]);
  std::ranges::fill(edit(brick), log_odds::kUnseen);
  summaries_[brick] = {};
}

void VoxelMap::enter(const Index& at, BrickStore* store) {
  const std::size_t brick = brick_index(at);
  note_change(brick % column_changed_.size());
  if (store == nullptr || !store->give_back(key(at), edit(brick), summaries_[brick])) return;
  // When the foot of a column was last observed is not kept; at the latest change of its brick, it was.
  for (int cube = 0; cube < 8; ++cube) {
    std::uint64_t known = 0;
    for (int i = 0; i < 64; ++i) {
      const int layer = kBrickEdge * at.z() + voxel_of_brick(64 * cube + i).z;
      const bool foot = layer >= foot_begin_ && layer < foot_end_;
      const LogOdds value = values(brick)[static_cast<std::size_t>(64 * cube + i)];
      if (foot && value != log_odds::kUnseen) known |= std::uint64_t{1} << i;
    }
    see_columns(at, cube & 3, columns_of_cube(known), summaries_[brick].changed);
  }
}

Time VoxelMap::floor_seen_at(int x, int y) const {
  const Index n = size();
  return x >= 0 && y >= 0 && x < n.x() && y < n.y() ? floor_seen_[column(x, y)] : kNever;
}

void VoxelMap::see_columns(const Index& brick, int quarter, std::uint16_t columns, Time stamp) {
  Time* seen = floor_seen_.data() + columns_of(brick) + 16 * quarter;
  note_change(columns_of(brick) / kColumns);
  if (columns == 0xffff) {
    std::fill_n(seen, 16, stamp);
    return;
  }
  for (unsigned left = columns; left != 0; left &= left - 1) seen[std::countr_zero(left)] = stamp;
}

}  // namespace headway::nav
