// Range images in inverse depth w = 1/Z, where a stereo camera's noise is the same everywhere and planes are
// linear: made smaller and freed of outliers.
#pragma once

#include <cstddef>
#include <vector>

#include "nav/ring_image.h"
#include "vision/range_view.h"

namespace headway::nav {

/// Less than any inverse depth [1/m].
inline constexpr float kLeastKnown = 1e-6F;

/// Inverse depths and their standard deviations [1/m]; 0 where nothing is known.
struct InverseDepth {
  RingImage<float> w, sigma;

  void reset(int width, int height) {
    w.reset(width, height);
    sigma.reset(width, height);
  }
};

/// Which two of four rows are read of a view made four times smaller: the others err much as they do. Views
/// take turns, so that nothing two pixels high goes unseen however still the camera stands.
enum class RowsRead { kOuter, kInner };

/// What becomes of a view's size: 1/`times` (1, 2 or 4) of it.
struct Reduction {
  int times;
  RowsRead rows = RowsRead::kOuter;
};

/// Makes views smaller; keeps its memory.
class DepthReducer {
 public:
  /// Of each block of 2x2 pixels that is taken together, the mean of the nearest two or more that lie on one
  /// surface, so that thin things stay and a lone wrong pixel does not. Pixels nearer than the view's near,
  /// or with less inlier weight than `least_weight`, are unknown. `resolution` is a voxel's edge [m].
  void reduce(const vision::RangeView& view, float least_weight, float resolution, Reduction reduction,
              InverseDepth& out);

 private:
  struct {
    RingImage<float> nearness, sigma;
  } half_;                      ///< one row [m]
  std::vector<float> nothing_;  ///< the row below an odd last one
};

/// The mean of each sample and those of its eight neighbours, `reach` samples away, that lie on the same
/// surface. Samples with fewer than `supporters` such neighbours are dropped: their number is returned.
/// `mean_sigma`, unless null, becomes sigma as it is wider where fewer samples share a mean than inside of a
/// surface: errors that neighbours have in common do not average out, hence in proportion to their number.
std::size_t smooth(const RingImage<float>& in, const RingImage<float>& sigma, int reach, int supporters,
                   float resolution, RingImage<float>& out, RingImage<float>* mean_sigma = nullptr);

/// Fills single holes in surfaces: samples of which nothing is known take the mean of their neighbours where
/// at least six of eight lie on one surface. Their sigma goes into `rough`, which keeps its holes otherwise.
void fill_holes(InverseDepth& rough, float resolution, RingImage<float>& smooth_w,
                RingImage<float>& mean_sigma);

}  // namespace headway::nav
