// What is known of the space around the robot: each voxel is unseen, empty or occupied.
//
// Log-odds in one byte, in bricks of 8x8x8 that fill a box; everything is allocated at construction. The box
// is a window that can follow the robot: bricks are addressed as on a torus, so that those that stay are not
// touched, and those that leave make room for those that enter.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/time.h"
#include "nav/brick.h"
#include "nav/brick_store.h"

namespace headway::nav {

enum class Voxel : std::uint8_t { kUnseen = 0, kEmpty = 1, kOccupied = 2 };

/// The class of a voxel with this value.
constexpr Voxel voxel_of(LogOdds value) {
  if (value == log_odds::kUnseen) return Voxel::kUnseen;
  return value >= log_odds::kOccupied ? Voxel::kOccupied : Voxel::kEmpty;
}

/// A box in the map frame (z = 0 is the floor), where the window is at first. It grows outward to whole
/// bricks.
struct VoxelMapConfig {
  double resolution = 0.05;                  ///< edge of a voxel [m]
  Eigen::Vector3d lowest{-4.0, -4.0, -0.4};  ///< corner of the box [m]
  Eigen::Vector3d highest{4.0, 4.0, 2.8};    ///< opposite corner [m]
  double floor_band = 0.1;  ///< voxels with centres this near the floor's height [m] are a column's foot
  double obstacle_height = 1.70;  ///< a hit up to here [m] also says what stands on the column's foot

  /// Throws InputError when a value is out of bounds or the box would not fit into memory or OctoMap's keys.
  void validate() const;
};

/// The bricks of a box: keys from `first` up to, not including, `end`.
struct BrickRange {
  Eigen::Vector3i first, end;
};
BrickRange bricks_in(const VoxelMapConfig& config);

class VoxelMap {
 public:
  static constexpr int kBrickEdge = nav::kBrickEdge;
  static constexpr int kBrickVoxels = nav::kBrickVoxels;
  using Index = Eigen::Vector3i;  ///< voxel coordinates, (0, 0, 0) at the window's lowest corner

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

  /// Moves the window by whole bricks so that `centre` [m] lies in its middle, as far as OctoMap's keys
  /// reach. Bricks that leave and of which something is known go to `store`, and bricks that enter come from
  /// it; without one they are forgotten, and unseen. Voxel indices mean other places afterwards.
  void roll_to(const Eigen::Vector3d& centre, BrickStore* store);

  // Bricks, for code that goes through the whole map. They have numbers 0 .. brick_count() - 1, which stay
  // theirs as long as they are in the window, and coordinates, (0, 0, 0) at the window's lowest corner.
  const Index& bricks() const { return bricks_; }
  std::size_t brick_count() const { return summaries_.size(); }
  /// Memory held [bytes]; the same from construction on.
  std::size_t bytes() const;
  std::size_t brick_index(const Index& brick) const {
    return (wrapped(brick, 2) * static_cast<std::size_t>(bricks_.y()) + wrapped(brick, 1)) *
               static_cast<std::size_t>(bricks_.x()) +
           wrapped(brick, 0);
  }
  Index brick_at(std::size_t brick) const;
  BrickKey key(const Index& brick) const {
    const Index k = first_key_ / kBrickEdge + brick;
    return {k.x(), k.y(), k.z()};
  }
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
  /// The same when it is known by how much the counts changed.
  void count_change(std::size_t brick, int unseen, int occupied, Time stamp) {
    BrickSummary& s = summaries_[brick];
    s.unseen = static_cast<std::uint16_t>(s.unseen + unseen);
    s.occupied = static_cast<std::uint16_t>(s.occupied + occupied);
    s.changed = stamp;
    note_change(brick % column_changed_.size());
  }

  /// Views integrated so far.
  std::uint64_t views() const { return views_; }
  void count_view() { ++views_; }

  /// Changes of anything known so far: of values, of when a floor column was seen, and of the window's place.
  std::uint64_t changes() const { return changes_; }
  /// What `changes` was after the last one in a column of bricks (x, y) of the window; 0 before the first.
  std::uint64_t column_changed(int x, int y) const {
    return column_changed_[brick_index({x, y, 0}) % column_changed_.size()];
  }
  /// Bit per cube of 4x4x4 voxels: those known to be emptied as far as log-odds go, which another miss leaves
  /// as they are. Whoever raises a value in a cube clears its bit; `settle` clears all.
  std::uint8_t& emptied(std::size_t brick) { return emptied_[brick]; }

  /// When the foot of column (x, y) was last observed: the floor there, or what stands on it. kNever before,
  /// and outside the box.
  Time floor_seen_at(int x, int y) const;
  /// Notes an observation of a column of the box.
  void see_floor(int x, int y, Time stamp) {
    floor_seen_[column(x, y)] = stamp;
    note_change(column(x, y) / kColumns);
  }
  /// The same of columns of a brick's quarter (0..3: y >= 4, x >= 4 in binary): those whose bit y * 4 + x is
  /// set.
  void see_columns(const Index& brick, int quarter, std::uint16_t columns, Time stamp);
  /// Voxel layers [first, last) whose centres lie within the floor band.
  int foot_begin() const { return foot_begin_; }
  int foot_end() const { return foot_end_; }

 private:
  std::size_t offset(const Index& i) const {
    return brick_index({i.x() >> 3, i.y() >> 3, i.z() >> 3}) * kBrickVoxels +
           static_cast<std::size_t>(in_brick(i.x() & 7, i.y() & 7, i.z() & 7));
  }
  /// A brick's coordinate along an axis on the torus.
  std::size_t wrapped(const Index& brick, int axis) const {
    const int at = brick[axis] + turned_[axis];
    return static_cast<std::size_t>(at < bricks_[axis] ? at : at - bricks_[axis]);
  }
  /// The first of the 64 columns of a brick.
  std::size_t columns_of(const Index& brick) const {
    return (wrapped(brick, 1) * static_cast<std::size_t>(bricks_.x()) + wrapped(brick, 0)) * kColumns;
  }
  std::size_t column(int x, int y) const {
    const int quarter = (y >> 2 & 1) << 1 | (x >> 2 & 1);
    return columns_of({x >> 3, y >> 3, 0}) + static_cast<std::size_t>(quarter << 4 | (y & 3) << 2 | (x & 3));
  }
  /// Columns of bricks have the numbers of their first bricks.
  void note_change(std::size_t column) { column_changed_[column] = ++changes_; }
  void find_foot();
  template <class Visit>
  void for_each_outside(const Index& shift, const Visit& visit) const;
  void leave(const Index& at, BrickStore* store);
  void enter(const Index& at, BrickStore* store);

  static constexpr std::size_t kColumns = 64;  ///< of a brick, by quarters

  VoxelMapConfig config_;
  Index first_key_, bricks_;
  Index turned_ = Index::Zero();  ///< of the torus [bricks]
  int foot_begin_ = 0, foot_end_ = 0;
  std::vector<LogOdds> values_;
  std::vector<BrickSummary> summaries_;
  std::vector<std::uint8_t> emptied_;  ///< of bricks
  std::vector<Time> floor_seen_;       ///< of columns of voxels
  std::uint64_t views_ = 0, changes_ = 0;
  std::vector<std::uint64_t> column_changed_;  ///< of columns of bricks
};

}  // namespace headway::nav
