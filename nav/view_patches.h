// A range view as some thousand points, each the mean of a square of pixels that lie on one plane: fewer and
// surer than pixels, and none of them on a depth edge.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "vision/range_view.h"

namespace headway::nav {

struct PatchConfig {
  int most = 3000;               ///< patches of a view; sets the size of the squares
  double least_weight = 0.8;     ///< pixels with less inlier weight say nothing
  double correlation = 2;        ///< [px] neighbours as near as this err alike
  double most_independent = 16;  ///< so many pixels at most count as independent: what errs alike stays

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

struct Patch {
  Eigen::Vector3d point;  ///< on the surface, in the view's optical frame [m]
  double sigma = 0;       ///< of the point along its ray, as a share of its depth
  double alike = 0;       ///< of sigma, what patches nearby err in common: all with a matcher, else nothing
};

/// The patches of a view, row by row; points beyond the view's far are left out.
void view_patches(const vision::RangeView& view, const PatchConfig& config, std::vector<Patch>& out);

}  // namespace headway::nav
