// How precisely a rectified rig sees a place: the largest standard deviation of a point there, and the
// polytope of all places it sees at least so well.
#pragma once

#include <vector>

#include "vision/hull.h"
#include "vision/polytope.h"
#include "vision/rectified_rig.h"

namespace headway::vision {

/// sqrt of the largest eigenvalue [m] of Sigma = (Z/f)^2 diag(su^2, su^2, 0) + (sigma_d/d)^2 P P^T, the
/// covariance of RangeView, in closed form. `point` in the left camera's optical frame [m], Z > 0.
double resolution(const RectifiedRig& rig, const Eigen::Vector3d& point);

/// Points of `field` (the rig's polytope, bounded) on the boundary of the part that is seen with at most
/// `finest` [m]: along the rays of a lattice of pixels of both cameras, from where each enters the part to
/// where it leaves. A larger resolution gives points that lie farther along the same rays.
std::vector<Eigen::Vector3d> resolved_points(const RectifiedRig& rig, const Polytope& field,
                                             double resolution);

/// The hull of those points: the rig's polytope for a resolution. Grows with the resolution and lies inside
/// `field`. Nothing when no place is seen so well.
std::optional<Polytope> resolution_polytope(const RectifiedRig& rig, const Polytope& field,
                                            double resolution);

}  // namespace headway::vision
