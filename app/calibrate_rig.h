// headway calibrate: pairs of images of a board in, a rig file and what it is worth out.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "vision/board.h"
#include "vision/calibration.h"

namespace headway::app {

struct RigCalibrationOptions {
  std::vector<std::string> paths;  ///< as find_image_pairs takes them
  vision::Board board;
  vision::Lenses lenses = vision::Lenses::kEach;
  std::string name = "calibrated";
  double nearest = 0.8, farthest = 6.0;  ///< [m]; for the rig file
  std::filesystem::path out;
};

/// Epipolar error (mean row distance) above which a rig is not fit for matching [px].
inline constexpr double kLargestEpipolarError = 0.5;

/// Writes rig.yaml, report.json and coverage.png; returns the exit code. Throws InputError.
int calibrate_rig(const RigCalibrationOptions& options);

}  // namespace headway::app
