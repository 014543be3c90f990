// The occupied voxels of a brick as few boxes, so that what goes through solid things need not go voxel by
// voxel.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "nav/voxel_map.h"

namespace headway::nav {

/// Voxels [low, high) of a brick, each coordinate 0..8.
struct SolidBox8 {
  std::array<std::uint8_t, 3> low{}, high{};
};

/// Boxes that hold every occupied voxel of a brick once and no other.
class SolidBoxes {
 public:
  explicit SolidBoxes(std::span<const LogOdds, VoxelMap::kBrickVoxels> values);

  const SolidBox8* begin() const { return boxes_.data(); }
  const SolidBox8* end() const { return boxes_.data() + count_; }

 private:
  std::array<SolidBox8, VoxelMap::kBrickVoxels / 2>
      boxes_;  // no neighbours left apart: a chessboard has most
  std::size_t count_ = 0;
};

}  // namespace headway::nav
