// Keeps a floor map up to date with a voxel map, looking only into columns of bricks that have changed.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "nav/floor_map.h"
#include "nav/voxel_map.h"

namespace headway::nav {

/// What floor_map does, piece by piece. The floor may be larger than the voxel map's window: cells that it
/// has left stay as they were last known.
class FloorProjection {
 public:
  /// For floor maps with this grid, on which the voxel map's columns lie. Throws InputError as
  /// FloorMapConfig::validate.
  explicit FloorProjection(const FloorGrid& grid, const FloorMapConfig& config = {});

  /// Brings `floor` up to date with all changes since the last call, to the cell what floor_map makes of the
  /// whole map. `map` and `floor` must be those of the last call; the first finds the floor unseen. What lies
  /// outside of the grid is left out.
  void update(const VoxelMap& map, FloorMap& floor);
  /// What else than voxels makes a cell (of the grid) occupied; the next update decides it again. An
  /// occupied cell is low when no voxel in it is higher, or no sure one where it or one beside it rises so:
  /// what rises a little smears towards the camera, and up. Where the floor is known to be level, low voxels
  /// are the smear of what is known to rise near by.
  enum class Rise : std::uint8_t { kUnknown, kLevel, kLow, kHigh };
  void set_rise(const Eigen::Vector2i& cell, Rise rise) {
    rises_[grid_.index(cell)] = rise;
    const Eigen::Vector2i around = Eigen::Vector2i::Constant(kSmearReach);
    again_.extend(Eigen::AlignedBox2i(cell - around, cell + around));
  }
  /// Within these cells only what is known to be low is low; farther off what has no higher voxel is taken
  /// for low until it has been looked at from near.
  void look_closely_within(const Eigen::AlignedBox2i& cells) {
    again_.extend(near_);
    again_.extend(cells);
    near_ = cells;
  }
  /// Makes the next update decide these cells (those of the grid) again, for someone writes over them.
  void again(const Eigen::AlignedBox2i& cells) { again_.extend(cells); }

  /// Columns of bricks that the last update looked into.
  std::size_t columns_looked_into() const { return changed_.size(); }

 private:
  static constexpr int kSmearReach = 2;  ///< [cells]

  /// What stands on a cell.
  struct Column {
    std::uint8_t obstacles = 0;  ///< occupied voxels between floor tolerance and body height, up to 28
    bool strong = false;         ///< one of them is sure
    bool floor = false;          ///< an occupied voxel at the foot
    bool tall = false, surely_tall = false;  ///< one of the obstacles, or a sure one, is higher than low
  };

  void gather(const VoxelMap& map, const Eigen::Vector2i& bricks, const Eigen::Vector2i& first,
              FloorMap& floor);
  void gather_brick(const VoxelMap& map, std::size_t brick, int first_z, const Eigen::Vector2i& first);
  void decide(const Eigen::AlignedBox2i& cells, FloorMap& floor) const;
  int obstacles_around(const Eigen::Vector2i& cell) const;
  bool is_occupied(const Eigen::Vector2i& cell) const;
  bool is_low(const Eigen::Vector2i& cell) const;
  template <class Is>
  bool any_around(const Eigen::Vector2i& cell, int reach, const Is& is) const;

  FloorGrid grid_;
  FloorMapConfig config_;
  std::vector<Column> columns_;           ///< FloorGrid::index
  std::vector<Rise> rises_;               ///< FloorGrid::index
  std::uint64_t changes_ = 0;             ///< of the map, known to the floor
  std::vector<Eigen::Vector2i> changed_;  ///< first cells of columns of bricks
  Eigen::AlignedBox2i again_, near_;
};

}  // namespace headway::nav
