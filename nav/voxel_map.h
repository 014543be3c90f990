// What is known of the space around the robot: each voxel is unseen, empty or occupied.
//
// Log-odds in one byte, in bricks of 8x8x8 that fill a fixed box; everything is allocated at construction.
// Voxel boundaries lie at multiples of the resolution and brick boundaries at multiples of eight voxels, as
// OctoMap's keys do: a brick is one node of depth 13 of an octree of the same resolution.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/time.h"
#include "nav/brick.h"

namespace headway::nav {

enum class Voxel : std::uint8_t { kUnseen = 0, kEmpty = 1, kOccupied = 2 };

/// The class of a voxel with this value.
constexpr Voxel voxel_of(LogOdds value) {
  if (value == log_odds::kUnseen) return Voxel::kUnseen;
  return value >= log_odds::kOccupied ? Voxel::kOccupied : Voxel::kEmpty;
}

/// A box in the map frame (z = 0 is the floor). It grows outward to whole bricks.
struct VoxelMapConfig {
  double resolution = 0.05;                  ///< edge of a voxel [m]
  Eigen::Vector3d lowest{-4.0, -4.0, -0.4};  ///< corner of the box [m]
  Eigen::Vector3d highest{4.0, 4.0, 2.8};    ///< opposite corner [m]
  double floor_band = 0.1;  ///< voxels with centres this near the floor's height [m] are a column's foot
  double obstacle_height = 1.70;  ///< a hit up to here [m] also says what stands on the column's foot

  /// Throws InputError when a value is out of bounds or the box would not fit into memory or OctoMap's keys.
  void validate() const;
};

class VoxelMap {
 public:
  static constexpr int kBrickEdge = nav::kBrickEdge;
  static constexpr int kBrickVoxels = nav::kBrickVoxels;
  using Index = Eigen::Vector3i;  ///< voxel coordinates, (0, 0, 0) at the box's lowest corner

  /// All unseen. Throws InputError as VoxelMapConfig::validate.
  explicit VoxelMap(const VoxelMapConfig& config);

  const VoxelMapConfig& config() const { return config_; }
  double resolution() const { return config_.resolution; }
  Index size() const { return kBrickEdge * bricks_; }  ///< voxels along x, y, z
  Eigen::Vector3d lowest() const { return first_key_.cast<double>() * config_.resolution; }
  Eigen::Vector3d highest() const { return (first_key_ + size()).cast<double>() * config_.resolution; }
  /// floor(coordinate / resolution) of voxel (0, 0, 0): OctoMap's key of voxel i is first_key() + i + 32768.
  const Index& first_key() const { return first_key_; }

  /// The voxel that holds a point of the map frame [m]; may lie outside.
  Index index(const Eigen::Vector3d& point) const {
    return (point / config_.resolution).array().floor().cast<int>().matrix() - first_key_;
  }
  /// The middle of a voxel in the map frame [m].
  Eigen::Vector3d centre(const Index& i) const {
    return ((i + first_key_).cast<double>().array() + 0.5).matrix() * config_.resolution;
  }
  bool contains(const Index& i) const {
    const Index n = size();
    return (i.array() >= 0).all() && (i.array() < n.array()).all();
  }

  /// kUnseen outside the box.
  Voxel at(const Index& i) const { return voxel_of(value(i)); }
  Voxel at_point(const Eigen::Vector3d& point) const { return at(index(point)); }
  /// log_odds::kUnseen outside the box.
  LogOdds value(const Index& i) const { return contains(i) ? values_[offset(i)] : log_odds::kUnseen; }
  /// Sets one voxel (of the box) and all that is derived from it. For readers and tests; views go through
  /// Integrator.
  void set(const Index& i, LogOdds value, Time stamp);

  // Bricks, for code that goes through the whole map. Brick b = (bz * bricks().y() + by) * bricks().x() + bx.
  const Index& bricks() const { return bricks_; }
  std::size_t brick_count() const { return summaries_.size(); }
  std::size_t brick_index(const Index& brick) const {
    return (static_cast<std::size_t>(brick.z()) * static_cast<std::size_t>(bricks_.y()) +
            static_cast<std::size_t>(brick.y())) *
               static_cast<std::size_t>(bricks_.x()) +
           static_cast<std::size_t>(brick.x());
  }
  Index brick_at(std::size_t brick) const;
  const BrickSummary& summary(std::size_t brick) const { return summaries_[brick]; }
  /// The 512 values of a brick; voxel (x, y, z) of it, each 0..7, at `in_brick`.
  std::span<const LogOdds, kBrickVoxels> values(std::size_t brick) const {
    return std::span<const LogOdds, kBrickVoxels>(values_.data() + brick * kBrickVoxels, kBrickVoxels);
  }
  static constexpr int in_brick(int x, int y, int z) { return nav::in_brick(x, y, z); }

  /// As `values`, to change them; follow with `settle`.
  std::span<LogOdds, kBrickVoxels> edit(std::size_t brick) {
    return std::span<LogOdds, kBrickVoxels>(values_.data() + brick * kBrickVoxels, kBrickVoxels);
  }
  /// Counts the brick again after an edit and stamps it.
  void settle(std::size_t brick, Time stamp);

  /// When the foot of column (x, y) was last observed: the floor there, or what stands on it. kNever before,
  /// and outside the box.
  Time floor_seen_at(int x, int y) const;
  /// Notes an observation of a column of the box.
  void see_floor(int x, int y, Time stamp) { floor_seen_[column(x, y)] = stamp; }
  /// Voxel layers [first, last) whose centres lie within the floor band.
  int foot_begin() const { return foot_begin_; }
  int foot_end() const { return foot_end_; }

 private:
  std::size_t offset(const Index& i) const {
    return brick_index({i.x() >> 3, i.y() >> 3, i.z() >> 3}) * kBrickVoxels +
           static_cast<std::size_t>(in_brick(i.x() & 7, i.y() & 7, i.z() & 7));
  }
  std::size_t column(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(kBrickEdge * bricks_.x()) +
           static_cast<std::size_t>(x);
  }

  VoxelMapConfig config_;
  Index first_key_, bricks_;
  int foot_begin_ = 0, foot_end_ = 0;
  std::vector<LogOdds> values_;
  std::vector<BrickSummary> summaries_;
  std::vector<Time> floor_seen_;  ///< row-major, one per column of voxels
};

}  // namespace headway::nav
