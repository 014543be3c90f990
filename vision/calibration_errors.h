// How well a rig fits what it sees of a board: rows after rectification, the length of its squares, and which
// pairs stand out.
#pragma once

#include <vector>

#include "vision/board.h"
#include "vision/rectify.h"

namespace headway::vision {

/// Row distance of the same corner in both rectified images [px].
struct EpipolarError {
  double mean = 0;  ///< of the absolute distances
  double rms = 0;
  double largest = 0;
};
EpipolarError epipolar_error(const Rectifier& rectifier, const std::vector<SharedCorners>& pairs);

/// Length of a square's edge as the rig triangulates it (neighbouring corners, along rows and columns), over
/// the length it truly has: 1 says that focal length, baseline and board agree.
struct SquareLength {
  double mean = 0, sigma = 0;
};
SquareLength measured_square(const Rectifier& rectifier, const Board& board,
                             const std::vector<SharedCorners>& pairs);

/// Which of these errors are not like the rest: above the median by more than 4 robust standard deviations
/// (1.4826 times the median distance from the median) and by more than a quarter of the median.
std::vector<bool> standing_out(const std::vector<double>& errors);

}  // namespace headway::vision
