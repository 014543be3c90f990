// Range images in inverse depth w = 1/Z, where a stereo camera's noise is the same everywhere and planes are
// linear: made smaller and freed of outliers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "vision/range_view.h"

namespace headway::nav {

/// Inverse depths and their standard deviations, with a ring of zeros around so that neighbours need no
/// checks.
struct InverseDepthImage {
  static constexpr int kRing = 2;

  int width = 0, height = 0;
  std::vector<float> w;      ///< [1/m]; 0 where nothing is known
  std::vector<float> sigma;  ///< [1/m]

  int stride() const { return width + 2 * kRing; }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y + kRing) * static_cast<std::size_t>(stride()) +
           static_cast<std::size_t>(x + kRing);
  }
  /// All unknown.
  void reset(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    const std::size_t n = static_cast<std::size_t>(stride()) * static_cast<std::size_t>(height + 2 * kRing);
    w.assign(n, 0.0F);
    sigma.assign(n, 0.0F);
  }
};

/// Differences of inverse depth up to this lie on one surface: four sigma, or a voxel's edge in depth.
inline float same_surface(float w, float sigma, float resolution) {
  return std::max(4 * sigma, resolution * w * w);
}

/// The pixels of a view; none nearer than its near, none with less inlier weight than `least_weight`.
void invert(const vision::RangeView& view, float least_weight, InverseDepthImage& out);

/// Halves an image: of each 2x2 block the mean of the nearest two or more that lie on one surface, so that
/// thin things stay and a lone wrong pixel does not. `resolution` is a voxel's edge [m].
void halve(const InverseDepthImage& in, float resolution, InverseDepthImage& out);

/// Drops samples with fewer than `supporters` neighbours on the same surface, and takes the others' mean with
/// those opposite pairs of neighbours that lie on it (a pair keeps the mean of a slope where it is). Returns
/// how many samples were dropped.
std::size_t smooth(const InverseDepthImage& in, int supporters, float resolution, InverseDepthImage& out);

}  // namespace headway::nav
