// headway calibrate --head: images of a board that stands still and the head's angles in; the camera's place
// on the neck, the joints' zeros and the time offset out.
#pragma once

#include <filesystem>
#include <optional>

#include "vision/board.h"
#include "vision/head_calibration.h"

namespace headway::app {

struct HeadCalibrationOptions {
  /// Images of the left camera, named by their stamp [ns], and head.csv (as read_head_table takes it).
  std::filesystem::path folder;
  std::filesystem::path rig, robot;
  vision::Board board;
  std::optional<vision::MeasuredCorner> corner;
  std::filesystem::path out;
};

/// Distance of seen corners from projected ones (rms) above which the result does not explain the images
/// [px].
inline constexpr double kLargestHeadError = 1;

/// Writes neck.yaml, report.json and views.png; returns the exit code. Throws InputError.
int calibrate_head_of(const HeadCalibrationOptions& options);

}  // namespace headway::app
