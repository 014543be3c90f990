// The inner loops of semi-global matching: one image row at a time, all disparities of a pixel at once, in
// the widest vectors of the processor up to 32 bytes. The same bytes on every processor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "vision/census.h"

namespace headway::vision {

/// A cost above all that a pixel inside the right image can come to, for those outside of it: never the
/// winner, and no path gains from it. Costs of pixels are at most 36 (Census::kLargestDistance), penalties at
/// most 90, so that 36 + 90 < 128, 128 - 36 > 90 and 128 + 90 fits a byte.
constexpr std::uint8_t kOutsideCost = 128;

/// What is the same for all rows. `padded` is the number of bytes per pixel: `count` rounded up to what the
/// loops are made for (padded_count); disparities beyond `count` cost kOutsideCost.
struct SgmFacts {
  int width = 0, lowest = 0, count = 0, padded = 0;
  int first_column = 0, end_column = 0;
  std::uint8_t p1 = 0;
  std::array<std::uint8_t, 511> p2{};     ///< by the difference of grey values, -255 to 255
  const std::uint8_t* outside = nullptr;  ///< `padded` bytes of kOutsideCost, of 0, and again of kOutsideCost
  std::uint8_t* scratch = nullptr;        ///< kScratchRows rows of scratch_pitch() bytes
};

/// Rows of the images' comparisons, four to the byte.
constexpr int kScratchRows = 4 * Census::kBitPlanes;
inline int scratch_pitch(const SgmFacts& f) { return f.width + f.padded + 32; }

/// One row of the images: the planes of the left one at column 0, those of the right one where the partner of
/// column 0 at the lowest disparity lies (higher disparities at higher addresses), the left image's grey
/// values and those of the row before, in the direction of the vertical path.
struct SgmRowInput {
  std::array<const std::uint8_t*, Census::kPlanes> left, right;
  const std::uint8_t *grey, *grey_before;
};

/// What the backward pass finds, by column. `below` and `above` are the sums beside the winner's, its own at
/// the ends of the range; `second` is the least sum that is not beside the winner's. right_winner[x] belongs
/// to column x - lowest of the right image; it is also written for the `padded` columns before the first.
struct SgmRowOutput {
  std::uint8_t *winner, *least, *second, *below, *above, *right_winner;
};

/// Bytes between the columns of a vertical path's state: the costs, and before and after them bytes of 255.
constexpr int kStateMargin = 32;
inline std::size_t state_size(const SgmFacts& f) {
  return static_cast<std::size_t>(f.width) * static_cast<std::size_t>(f.padded + kStateMargin) + kStateMargin;
}

struct SgmKernels {
  /// Cost and vertical path only: from the path's state at the row before to that of this row. Both may be
  /// one.
  void (*vertical)(const SgmFacts&, const SgmRowInput&, const std::uint8_t* before, std::uint8_t* state);
  /// From left to right: cost, left path, vertical path. `state` is the latter's at the row before, and
  /// becomes that of this row. `costs` and `sums` take `padded` bytes per column.
  void (*forward)(const SgmFacts&, const SgmRowInput&, std::uint8_t* state, std::uint8_t* costs,
                  std::uint8_t* sums);
  /// From right to left: right path, vertical path from the other side (unless `state` is null), and the
  /// winners of both images.
  void (*backward)(const SgmFacts&, const SgmRowInput&, std::uint8_t* state, const std::uint8_t* costs,
                   std::uint8_t* sums, const SgmRowOutput&);
};

/// The least number of bytes per pixel that kernels exist for; count is 1 to 256.
int padded_count(int count);

/// For this processor.
SgmKernels sgm_kernels(int padded);

}  // namespace headway::vision
