// The voxels that single points of one view lie in, so that nothing thinner than a voxel is overlooked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/brick.h"

namespace headway::nav {

/// One bit per voxel, in words of 4x4x4 voxels as `in_brick` has them. Memory is kept from view to view.
class VoxelMarks {
 public:
  static constexpr int kWords = 8;  ///< per brick

  /// Forgets all marks. `bricks`: how many there are.
  void reset(std::size_t bricks) {
    if (words_.size() != bricks * kWords) {
      words_.assign(bricks * kWords, 0);
      marked_.assign(bricks, 0);
    } else {
      for (const std::uint32_t brick : bricks_) clear(brick);
    }
    bricks_.clear();
  }

  /// Marks a voxel: `place` as in_brick.
  void mark(std::uint32_t brick, std::uint32_t place) {
    if (!marked_[brick]) {
      marked_[brick] = 1;
      bricks_.push_back(brick);
    }
    words_[std::size_t{brick} * kWords + (place >> 6)] |= std::uint64_t{1} << (place & 63);
  }

  bool any(std::size_t brick) const { return marked_[brick] != 0; }
  std::uint64_t word(std::size_t brick, int cube) const {
    return words_[brick * kWords + static_cast<std::size_t>(cube)];
  }
  /// Bricks that hold marks, in the order of their first.
  const std::vector<std::uint32_t>& bricks() const { return bricks_; }
  /// Forgets the marks of a brick; it stays in `bricks`.
  void clear(std::size_t brick) {
    marked_[brick] = 0;
    for (std::size_t k = 0; k < kWords; ++k) words_[brick * kWords + k] = 0;
  }

 private:
  std::vector<std::uint64_t> words_;
  std::vector<std::uint8_t> marked_;
  std::vector<std::uint32_t> bricks_;
};

}  // namespace headway::nav
