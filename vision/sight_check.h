// Whether two cameras still see as they did when they were calibrated: covered, blinded, blurred, bent or
// swapped ones are named, with the numbers behind it.
#pragma once

#include <string>
#include <vector>

#include "hal/frame.h"
#include "vision/rectify.h"

namespace headway::vision {

/// What one rectified image looks like.
struct CameraSight {
  double brightness = 0;  ///< mean grey value, 0..255
  double black = 0;       ///< share of pixels of grey value 4 and below
  double white = 0;       ///< share of 251 and above
  double texture = 0;     ///< share of the image's cells with something in them to recognise
  double sharpness = 0;   ///< how much of the contrast lies in the finest detail; 0 without contrast
};

/// What they show together, from small pieces of the left image that are looked for in the right one: in rows
/// above and below too, and behind infinity.
struct PairSight {
  int looked_for = 0, found = 0;  ///< pieces
  double row_offset = 0;          ///< median of the row in the right image minus that in the left [px]
  double row_error = 0;           ///< median of its size [px]: the epipolar error; grows as the rig bends
  double behind_infinity = 0;  ///< share of the pieces found where no point in front of both cameras can be
};

enum class SightFault {
  kCovered,    ///< one camera shows nothing (a warning: half as much) while the other does; or both are dark
  kSaturated,  ///< too much of the image is white
  kBlurred,    ///< one camera is much less sharp than the other, or both show no detail
  kDifferent,  ///< little of one image is found in the other: not the same moment, or far off the calibration
  kDecalibrated,  ///< partners lie in different rows
  kSwapped,       ///< left and right are exchanged
};

enum class Severity {
  kWarning,  ///< depth is worse than it should be
  kFault,    ///< depth from this pair is not to be trusted
};

struct SightFinding {
  SightFault fault;
  Severity severity;
  std::string what;  ///< one sentence with the number and its limit
};

struct SightReport {
  CameraSight left, right;
  PairSight pair;
  std::vector<SightFinding> findings;  ///< empty for a healthy pair

  bool has(SightFault fault) const;
  /// The first finding that depth cannot be trusted after, or null.
  const SightFinding* fault() const;
};

/// Where warnings and faults begin.
struct SightConfig {
  double least_texture = 0.02,
         other_texture = 0.2;    ///< covered: below the first, while the other is above this
  double texture_warning = 0.5;  ///< texture of one camera over the other's
  double dark = 12;              ///< mean grey value below which nobody sees anything
  double white_warning = 0.25, white_fault = 0.6;
  double blur_warning = 0.75, blur_fault = 0.55;    ///< sharpness of one camera over the other's
  double least_sharpness = 0.1;                     ///< warning: both cameras below it
  int least_pieces = 20;                            ///< fewer prove nothing
  double found_warning = 0.25, found_fault = 0.12;  ///< share of the pieces that are found
  double row_warning = 0.35,
         row_fault = 0.75;  ///< [px]; half a pixel costs StereoSGBM a third of its matches
  double behind_fault = 0.3;
};

/// Looks at a rectified pair; both images must have the rig's size. The same bytes give the same report;
/// takes a few milliseconds.
SightReport check_sight(const hal::GrayImage& left, const hal::GrayImage& right, const RectifiedRig& rig,
                        const SightConfig& config = {});

/// The same where the raw pair is at hand: a pair that does not fit together, but would if its images were
/// exchanged before rectification, is named swapped and nothing else. `left` and `right` are `raw` after
/// rectification.
SightReport check_sight(const Rectifier& rectifier, const hal::StereoFrame& raw, const hal::GrayImage& left,
                        const hal::GrayImage& right, const SightConfig& config = {});

}  // namespace headway::vision
