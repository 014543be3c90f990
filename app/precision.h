// How precise a simulated walk's points are, against the truth: whether their 3-sigma bounds hold.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <vector>

#include "hal/time.h"
#include "sim_hal/scene.h"
#include "vision/range_view.h"

namespace headway::app {

/// Compares the depths of a sparse raster of pixels with the true ones, which are cast at the exposure.
class PrecisionCheck {
 public:
  struct Result {
    std::uint64_t points = 0;  ///< measured, with a truth
    std::uint64_t within_3_sigma = 0;
    double weight = 0, weight_within = 0;  ///< the same two, each point counted with its inlier weight
    std::uint64_t gross = 0;               ///< off by more than 10 % of the depth
    std::uint64_t at_edges = 0;            ///< of those outside 3 sigma: depth jumps beside the pixel
    /// Of the points within 3 sigma of the truth, each counted with its inlier weight.
    double share() const { return weight > 0 ? weight_within / weight : 0; }
  };

  /// Keeps the truth of an exposure; `map_from_view` is the true pose of the rectified left camera.
  void expose(Time exposure, const sim::Scene& scene, const vision::PinholeCamera& camera,
              const Eigen::Isometry3d& map_from_view);
  /// Judges the view of that exposure; unknown exposures are ignored.
  void judge(Time exposure, const vision::RangeView& view);

  const Result& result() const { return result_; }

 private:
  static constexpr int kStride = 6;  // pixels between samples
  struct Truth {
    Time exposure{};
    int width = 0;             ///< of the camera [px]; views of half the size are not judged
    std::vector<float> depth;  ///< Z [m] of the raster, row by row
    std::vector<bool> edge;    ///< depth jumps within two pixels
  };
  std::deque<Truth> waiting_;
  Result result_;
};

}  // namespace headway::app
