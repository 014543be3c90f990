// Finds small pieces of the left image in the right one without trusting the rig: over rows and behind
// infinity.
#pragma once

#include <vector>

#include "hal/frame.h"
#include "vision/rectified_rig.h"

namespace headway::vision {

/// Where a piece of the left image around (u, v) was found in the right one, at (u - disparity, v + row).
struct PieceMatch {
  int u = 0, v = 0;
  double disparity = 0, row = 0;  ///< [px]; the row to a fraction of a pixel
};

struct PieceSearch {
  double left_texture = 0, right_texture = 0;  ///< share of the images' cells with a corner worth looking for
  int looked_for = 0;
  std::vector<PieceMatch> found;
};

/// Takes at most one piece of each cell of the left image: its strongest corner, so that rows and columns are
/// told apart. Looks for it up to `rows` px above and below, from the nearest distance of the rig to as far
/// behind infinity, in images whose shorter side has about 120 px; then closely around the best place at full
/// size. Keeps what is alike (normalised correlation) and like nothing else.
PieceSearch search_pieces(const hal::GrayImage& left, const hal::GrayImage& right, const RectifiedRig& rig,
                          int rows = 16);

}  // namespace headway::vision
