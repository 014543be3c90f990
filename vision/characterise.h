// All that can be said of a rig before it has seen anything: its field and how many half-spaces that takes,
// how wide and how precisely it sees at each distance.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "vision/pixel_pairs.h"
#include "vision/polytope.h"
#include "vision/rectify.h"
#include "vision/resolution.h"
#include "vision/rig.h"
#include "vision/viewpoints.h"

namespace headway::vision {

/// How many half-spaces and corners the minimal A has.
struct PolytopeSize {
  std::size_t rows = 0, corners = 0;
};

/// What a rig sees at one depth Z.
struct SightAt {
  double depth = 0;    ///< [m]
  FieldAngles angles;  ///< of the common view
  double on_axis = 0;  ///< resolution [m] at vision::on_axis
  double worst = 0;    ///< resolution [m] in the farthest corner of the common view; 0 without one
  double measured =
      0;  ///< on the axis, from triangulated draws: sqrt of their covariance's largest eigenvalue
};

struct ResolvedField {
  double resolution = 0;  ///< [m]
  Polytope polytope;
  double farthest = 0;  ///< greatest depth Z among its corners [m]
};

struct Characteristics {
  RectifiedRig rectified;
  /// Of the rectified rig between its nearest and farthest depth: exactly the points that both rectified
  /// images show. Where a lens distorts or a camera is turned, the raw images show more at their rims, which
  /// rectification cuts off; `pairs` holds that too.
  Polytope field;
  std::array<PolytopeSize, 3> rectified_sizes{};  ///< no depth limit, near, near and far
  /// The same of the two cameras as they are mounted, with ideal lenses.
  std::array<PolytopeSize, 3> mounted_sizes{};
  int matcher_columns = 0;  ///< that a matcher without padding leaves out at the left (OpenCV's)
  double padded_share = 0;  ///< of the field's volume that those columns would cost
  PixelPairField pairs;  ///< the paper's way, of raw pixels; everything in the rectified left camera's frame
  std::vector<SightAt> sights;          ///< nearest to farthest depth, evenly in log Z
  std::vector<ResolvedField> resolved;  ///< those of the resolutions asked for that some place has
};

/// Of the rectifier's rig. Throws InputError for degenerate ones.
Characteristics characterise(const Rectifier& rectifier, const std::vector<double>& resolutions);

/// The place at depth `z` midway between the cameras, in the middle of the images' height [m].
Eigen::Vector3d on_axis(const RectifiedRig& rig, double z);

/// The spread of `draws` points that `triangulate` makes of the two pixels of on_axis(rig, z): their place
/// inside a pixel uniform and common to both, the right one's column wrong by the rig's disparity sigma. sqrt
/// of the largest eigenvalue of their covariance [m]. The same numbers are drawn every time.
double measured_resolution(const RectifiedRig& rig, double z, int draws = 2000);

/// The volume of a bounded polytope [m^3].
double volume(const Polytope& polytope);

}  // namespace headway::vision
