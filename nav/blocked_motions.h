// Which of the 72 motions are blocked from each cell: the obstacles dilated by every mask, 64 cells at a
// time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/masks.h"

namespace headway::nav {

/// One bit per cell, rows padded with a word of "outside" on either side.
class CellBits {
 public:
  /// Outside the raster every bit is `outside`.
  void reset(int width, int height, bool outside);
  void set(int x, int y) { row_of(y)[1 + x / 64] |= std::uint64_t{1} << (x % 64); }
  /// `words()` words; bit 0 of word 1 is the cell x = 0. Any row number will do.
  const std::uint64_t* row(int y) const;
  int words() const { return words_; }

 private:
  std::uint64_t* row_of(int y) {
    return bits_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(words_);
  }

  int width_ = 0, height_ = 0, words_ = 0;
  std::vector<std::uint64_t> bits_, outside_;
};

/// Row-major table of width x height cells.
class BlockedMotions {
 public:
  /// Nothing is blocked.
  void reset(int width, int height);

  /// Bit k set: motion k (0..8) from that heading is blocked.
  std::uint16_t at(std::size_t cell, int heading) const {
    return blocked_[cell][static_cast<std::size_t>(heading)];
  }
  void block(std::size_t cell, int heading, unsigned motions) {
    std::uint16_t& bits = blocked_[cell][static_cast<std::size_t>(heading)];
    bits = static_cast<std::uint16_t>(bits | motions);
  }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_ = 0, height_ = 0;
  std::vector<std::array<std::uint16_t, kHeadings>> blocked_;
};

/// Finds where masks meet obstacles. Each distinct run of cells is dilated once per row and shared by all
/// masks.
class MaskDilation {
 public:
  explicit MaskDilation(const Masks& masks);

  /// Blocks each motion from the rows first..last whose mask meets a set bit.
  void block(const CellBits& obstacles, int first, int last, BlockedMotions& into);
  /// Rows that the masks reach above and below their cell.
  int highest() const { return highest_; }
  int lowest() const { return lowest_; }

 private:
  struct Source {
    int dy, span;  ///< row of the mask, and which of the distinct runs
  };
  struct Span {
    int first, length;
    bool operator==(const Span&) const = default;
  };

  int span_number(const Span& span);
  void make_room(int width);
  std::uint64_t* dilated(int y, int span);
  void dilate_row(const CellBits& obstacles, int y);
  void block_row(int y, BlockedMotions& into);
  void scatter(int y, int heading, BlockedMotions& into) const;

  std::vector<Span> spans_;
  std::array<std::vector<Source>, kConfigurations> sources_;
  int lowest_ = 0, highest_ = 0, longest_ = 1;  ///< rows of all masks, cells of the longest run
  int words_ = 0;
  std::vector<std::uint64_t> runs_;  ///< the row in work dilated by runs of 1, 2, ... cells
  std::vector<std::uint64_t> ring_;  ///< [row modulo mask height][span][word]
  std::vector<std::uint64_t> hit_;   ///< [motion][word] of the row and heading in work
};

}  // namespace headway::nav
