// What a pixel looks like to the census matcher: how its grey value compares with its neighbours', and how
// steep the image is there. Neither changes when one camera is brighter than the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/frame.h"

namespace headway::vision {

/// Four bytes per pixel, one plane each. Three hold 24 comparisons of the 5x5 window: the 12 pairs that lie
/// opposite to each other about the centre (robust against noise), the 8 neighbours and the 4 corners with
/// the centre (sharp at edges). The fourth is a quarter of the horizontal Sobel value, cut off at
/// +-kSteepest, plus 128. Beyond the image's border its outermost pixels go on.
class Census {
 public:
  static constexpr int kBits = 24, kBitPlanes = 3, kSlopePlane = 3, kPlanes = 4;
  static constexpr int kSteepest = 12, kLevel = 128;
  static constexpr int kLargestDistance = kBits + kSteepest;  ///< of two pixels

  /// Of `image`, or of its mirror image (x counted from the right). Before the first and after the last pixel
  /// of each row `margin` bytes may be read; what they hold means nothing. Memory is kept between images of
  /// one size.
  void compute(const hal::GrayImage& image, bool mirrored, int margin);

  /// The first pixel of a row of a plane. The row of the next plane is pitch() bytes on.
  const std::uint8_t* row(int plane, int y) const {
    return planes_.data() + static_cast<std::size_t>(y * kPlanes + plane) * pitch_ + margin_;
  }
  std::ptrdiff_t pitch() const { return static_cast<std::ptrdiff_t>(pitch_); }

 private:
  std::size_t pitch_ = 0, margin_ = 0;
  std::vector<std::uint8_t> planes_;  // row by row, all planes of each
  std::vector<std::int8_t> padded_;   // the image less 128, with a border of two pixels
};

}  // namespace headway::vision
