// One bit per cell of the floor.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace headway::nav {

/// Rows of 64-bit words, padded so that a reader may go eight words past either end of the raster's whole
/// blocks of four words. Bits outside the raster are all alike.
class CellBits {
 public:
  /// Inside every bit is 0, outside `outside`.
  void reset(int width, int height, bool outside) {
    height_ = height;
    words_ = (width + 255) / 256 * 4 + 2 * kMargin;
    outside_.assign(static_cast<std::size_t>(words_), outside ? ~std::uint64_t{0} : 0);
    bits_.assign(static_cast<std::size_t>(words_) * static_cast<std::size_t>(height), 0);
    if (!outside) return;
    for (int y = 0; y < height; ++y) {
      std::uint64_t* row = word(0, y);
      for (int w = -kMargin; w < 0; ++w) row[w] = ~std::uint64_t{0};
      for (int w = width / 64; w < words_ - kMargin; ++w) row[w] = ~std::uint64_t{0};
      if (width % 64 != 0) row[width / 64] <<= width % 64;
    }
  }

  void set(int x, int y, bool value) {
    std::uint64_t& bits = *word(x / 64, y);
    const std::uint64_t bit = std::uint64_t{1} << (x % 64);
    bits = value ? bits | bit : bits & ~bit;
  }

  /// Sets the bits of the cells x = 0 .. width - 1 for which `is(x)` holds.
  template <class Is>
  void add_row(int y, int width, const Is& is) {
    for (int w = 0; 64 * w < width; ++w) {
      const int cells = std::min(64, width - 64 * w);
      std::uint64_t bits = 0;
      for (int i = 0; i < cells; ++i) bits |= static_cast<std::uint64_t>(is(64 * w + i)) << i;
      *word(w, y) |= bits;
    }
  }

  /// The word of the cells x = 0..63. Any row number will do.
  const std::uint64_t* row(int y) const {
    return (y < 0 || y >= height_ ? outside_.data() : bits_.data() + first(y)) + kMargin;
  }
  std::size_t bytes() const { return bits_.size() * sizeof(std::uint64_t); }

 private:
  static constexpr int kMargin = 8;
  std::size_t first(int y) const { return static_cast<std::size_t>(y) * static_cast<std::size_t>(words_); }
  std::uint64_t* word(int w, int y) { return bits_.data() + first(y) + kMargin + w; }

  int height_ = 0, words_ = 0;
  std::vector<std::uint64_t> bits_, outside_;
};

}  // namespace headway::nav
