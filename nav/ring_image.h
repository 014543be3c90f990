// An image with a ring of zeros around it, so that neither neighbours nor whole vectors need checks.
#pragma once

#include <cstddef>
#include <vector>

namespace headway::nav {

template <class T>
class RingImage {
 public:
  static constexpr int kRing = 4;    ///< samples around the image that are always zero
  static constexpr int kSlack = 32;  ///< more of them behind each row: two vectors of the widest kind

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t stride() const { return static_cast<std::size_t>(width_ + 2 * kRing + kSlack); }

  /// Sample (0, y); y from -kRing to height() + kRing - 1. Whoever writes whole vectors writes zeros behind
  /// the last sample.
  T* row(int y) { return values_.data() + start(y); }
  const T* row(int y) const { return values_.data() + start(y); }
  /// Sample (-kRing, -kRing).
  const T* data() const { return values_.data(); }

  /// Takes on a size. All is zero after a change; without one, nothing happens.
  void reset(int width, int height) {
    if (width == width_ && height == height_) return;
    width_ = width;
    height_ = height;
    values_.assign(stride() * static_cast<std::size_t>(height + 2 * kRing) + kSlack, T{});
  }

 private:
  std::size_t start(int y) const {
    return static_cast<std::size_t>(y + kRing) * stride() + static_cast<std::size_t>(kRing);
  }

  int width_ = 0, height_ = 0;
  std::vector<T> values_;
};

}  // namespace headway::nav
