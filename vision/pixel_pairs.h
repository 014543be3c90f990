// The paper's way to the field (section II): triangulate pixel pairs of both images, take their hull by
// Quickhull, and reduce its half-spaces to the minimal form. A cross-check of the analytic polytope, and the
// points that its figure 1 shows.
#pragma once

#include <cstddef>
#include <vector>

#include "hal/angle.h"
#include "vision/polytope.h"
#include "vision/rig.h"
#include "vision/rig_polytope.h"
#include "vision/triangulation.h"

namespace headway::vision {

struct PixelPairConfig {
  // Pixels taken of the images: their outermost and evenly spread others.
  int columns = 17, rows = 17;  ///< of the left one
  int right_columns = 170;      ///< of the right one: how densely depths are sampled
  double pixel_sigma = 0.25;    ///< standard deviation of each pixel coordinate [px], for the covariances
  /// Half-spaces closer than both are one. Exact arithmetic finds none of the hull's redundant: a facet
  /// between pixels rounded up and down differs from its neighbour by a hair.
  double merge_angle = 0.2 * kDegree;  ///< [rad]
  double merge_offset = 0.005;         ///< [m]
};

struct PixelPairField {
  std::size_t pairs = 0;               ///< that lie on each other's epipolar line, to the pixel
  std::vector<UncertainPoint> points;  ///< those that triangulate within the depth limits; left optical frame
  Polytope hull;                       ///< of the points
  Polytope minimal;                    ///< after merging: contains the hull
};

/// Pairs each left pixel with those along its epipolar line in the right image, one for every column that an
/// ideal lens would show there: the whole pixel next to the line. Both are pixels of the raw images; each
/// stands for the ray that its lens, distorting or not, sends there. Throws InputError for unusable rigs and
/// when the points span no volume.
PixelPairField pixel_pair_field(const StereoRig& rig, const FieldLimits& limits,
                                const PixelPairConfig& config = {});

}  // namespace headway::vision
