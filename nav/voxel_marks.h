// What single points of one view say about their own voxels, so that nothing thinner than a voxel is
// overlooked.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/voxel_map.h"

namespace headway::nav {

/// Marks in the bricks that a view's points lie in; memory is kept from view to view.
class VoxelMarks {
 public:
  using Mark = std::uint8_t;
  static constexpr Mark kNone = 0;
  static constexpr Mark kKeep = 1;  ///< not to be emptied by this view
  static constexpr Mark kHit = 2;   ///< a measured point lies in it
  using Brick = std::array<Mark, VoxelMap::kBrickVoxels>;

  /// Forgets all marks.
  void reset(const VoxelMap& map);
  /// Marks the voxel of a point given in voxels from the map's lowest corner, unless it holds a higher mark
  /// or the point lies outside.
  void mark(const Eigen::Vector3f& point, Mark mark);

  /// The marks of a brick; null when it has none.
  const Brick* at(std::size_t brick) const {
    const std::int32_t slot = slots_[brick];
    return slot < 0 ? nullptr : &pool_[static_cast<std::size_t>(slot)];
  }
  /// Bricks that hold marks, in the order of their first mark.
  const std::vector<std::size_t>& bricks() const { return marked_; }

 private:
  Eigen::Vector3f size_{0, 0, 0};
  std::size_t row_ = 0, layer_ = 0;  ///< bricks
  std::vector<std::int32_t> slots_;
  std::vector<Brick> pool_;
  std::vector<std::size_t> marked_;
};

}  // namespace headway::nav
