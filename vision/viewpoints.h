// Where to point the head so that a rig sees its surroundings: how wide the field is at a distance, which
// directions cover what the head can look at, and how much of it they truly show. Plain values, no OpenCV.
#pragma once

#include <vector>

#include "hal/head.h"
#include "hal/head_kinematics.h"
#include "vision/polytope.h"
#include "vision/rectified_rig.h"

namespace headway::vision {

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

/// Directions all over the limits, their ends among them, at most 0.1 rad apart: together their views show
/// all that the head can.
std::vector<hal::HeadAngles> all_directions(const hal::HeadLimits& limits);

/// The field in the chest frame when the head looks in each of these directions. `field` is in the camera's
/// optical frame that `neck` leads to.
std::vector<Polytope> fields_of(const Polytope& field, const hal::HeadKinematics& neck,
                                const std::vector<hal::HeadAngles>& views);

/// Shares (0..1) of the points at one distance from the neck that a set of views shows.
struct CoveredShares {
  double gaze = 0;   ///< of those that the head can point the camera's axis at
  double reach = 0;  ///< of those that any direction of the head would show
};

/// Measured on a lattice of directions around the neck (where the tilt joint lies at zero angles), `distance`
/// [m] away. The depth limits of `field` count, so leave them out to ask about directions alone.
CoveredShares covered(const Polytope& field, const hal::HeadKinematics& neck, const hal::HeadLimits& limits,
                      const std::vector<hal::HeadAngles>& views, double distance);

}  // namespace headway::vision
