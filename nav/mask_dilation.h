// Which of the 72 motions are blocked from each cell: the obstacles dilated by every mask, 256 cells at a
// time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nav/cell_bits.h"
#include "nav/floor_chunks.h"
#include "nav/masks.h"

namespace headway::nav {

/// Rows and blocks (of kBlockCells cells), both inclusive.
struct BlockRange {
  int first_row = 0, last_row = -1, first_block = 0, last_block = -1;
};

/// Each distinct run of cells is dilated once per row of obstacles and shared by all masks that have it.
class MaskDilation {
 public:
  explicit MaskDilation(const Masks& masks);

  /// Finds anew what is blocked within the range: each motion whose mask meets a set bit, and no other.
  void block(const CellBits& obstacles, const BlockRange& range, FloorChunks& into);
  /// The same beside what is blocked already. `straight_on`: also the forward motions without a turn.
  void block_more(const CellBits& obstacles, const BlockRange& range, FloorChunks& into,
                  bool straight_on = true);

  /// Rows that the masks reach below and above their cell, and columns to either side.
  int lowest() const { return lowest_; }
  int highest() const { return highest_; }
  int farthest() const { return farthest_; }

  struct Span {
    int first, length;  ///< cells
    bool operator==(const Span&) const = default;
  };
  struct Source {
    std::uint16_t row, span;  ///< of the mask from lowest() on, and which of the distinct spans
  };
  const std::vector<Span>& spans() const { return spans_; }
  const std::vector<Source>& sources(int slot) const { return sources_[static_cast<std::size_t>(slot)]; }
  bool meets(int slot) const { return straight_on_ || slot % kMotions != kStraightOn; }

 private:
  std::uint16_t span_number(const Span& span);

  std::vector<Span> spans_;
  std::array<std::vector<Source>, kConfigurations> sources_;  ///< [slot]
  int lowest_ = 0, highest_ = 0, farthest_ = 0;
  bool straight_on_ = true;
  std::vector<std::uint64_t> ring_;  ///< [row modulo a power of two][span][word]: rows dilated by each span
};

}  // namespace headway::nav
