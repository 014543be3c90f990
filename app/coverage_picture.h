// Where on its images a pair of cameras has seen the corners of a board.
#pragma once

#include <Eigen/Core>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/calibration.h"

namespace headway::app {

/// What one camera of the pairs saw.
std::vector<const vision::BoardView*> views_of(const std::vector<vision::BoardPair>& pairs,
                                               vision::BoardView vision::BoardPair::*side);

/// Images are divided into cells, about ten across, of about equal sides.
struct Coverage {
  int across = 0, down = 0;
  std::vector<int> corners;  ///< seen in each cell, row by row

  double share() const;  ///< of cells that saw any corner
};
Coverage coverage_of(const std::vector<const vision::BoardView*>& views, int width, int height);

/// Both images side by side: cells coloured by how many corners they saw, those that never did crossed out,
/// the corners as dots (of pairs that stand out in another colour). With a legend.
cv::Mat coverage_picture(const std::vector<vision::BoardPair>& pairs, const std::vector<bool>& standing_out,
                         int width, int height);

}  // namespace headway::app
