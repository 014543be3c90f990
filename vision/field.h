// What a rig can see: the convex piece of space where both cameras see a point, and the directions of the
// head that cover the surroundings with it. Plain values, no OpenCV.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "hal/head.h"
#include "vision/rectified_rig.h"

namespace headway::vision {

/// The polytope A x >= 0 (paper, section II): x = (x, y, z, 1) in the rectified left camera's optical frame
/// [m]. Each row is scaled so that A x is the distance to its plane [m]. No row is redundant: six for a
/// rectified rig.
struct Field {
  std::vector<Eigen::Vector4d> rows;
  std::vector<Eigen::Vector3d> corners;  ///< the vertices; eight for a rectified rig

  bool contains(const Eigen::Vector3d& point) const {
    for (const Eigen::Vector4d& row : rows)
      if (row.dot(point.homogeneous()) < 0) return false;
    return true;
  }
};

/// The field between the depths `near` and `far` [m]: points whose pixels lie inside both images. The columns
/// of the left image whose points the right camera does not see are outside. Empty when nothing is seen by
/// both.
Field field_of(const RectifiedRig& rig, double near, double far);

/// Opening angles [rad].
struct FieldAngles {
  double horizontal = 0, vertical = 0;
};

/// How wide the common view is at depth `z` [m], seen from midway between the cameras. Grows with z: the two
/// images overlap less near by. Zero where they do not overlap.
FieldAngles field_angles(const RectifiedRig& rig, double z);

/// What a set of viewpoints must cover.
enum class Coverage {
  kGaze,   ///< every direction the head can point the camera's axis at
  kReach,  ///< everything that any direction of the head would show, to the edges of its image
};

/// Directions of the head that cover what `limits` allow with a field of this size; neighbours overlap by at
/// least `overlap` (share of the field, 0..0.9). In the order of a boustrophedon from the lower limits, so
/// that the head turns little: pan sweeps left, then right, tilt goes down a row between.
std::vector<hal::HeadAngles> viewpoints(const hal::HeadLimits& limits, const FieldAngles& field,
                                        double overlap = 0, Coverage coverage = Coverage::kGaze);

}  // namespace headway::vision
