// From corners of a board, seen in many images, to what a calibration says of one camera or of a rig; with
// the standard deviation of every number. Where the corners come from (files, live cameras) is no matter
// here.
#pragma once

#include <string>
#include <vector>

#include "hal/error.h"
#include "vision/board.h"
#include "vision/calibration_covariance.h"
#include "vision/calibration_errors.h"
#include "vision/rig.h"

namespace headway::vision {

inline constexpr int kFewestViews = 4;  ///< of a board, for a calibration

struct CameraCalibration {
  CameraIntrinsics camera;
  double rms = 0;                   ///< distance of seen corners from reprojected ones [px]
  std::vector<double> view_rms;     ///< the same per view; 0 for an empty one
  std::vector<Estimate> estimates;  ///< "fx", "fy", "cx" and so on
};

/// Zhang's method (OpenCV's calibrateCamera), all parameters of CameraIntrinsics free; but k3 only where it
/// differs from zero by three standard deviations. Empty views are passed over. Throws InputError for fewer
/// than kFewestViews, and where the views do not determine the camera.
CameraCalibration calibrate_camera(const Board& board, const std::vector<BoardView>& views, int width,
                                   int height);

/// What both cameras see of the board at one moment.
struct BoardPair {
  BoardView left, right;
  std::string name = "one pair";  ///< for messages
};

/// What is known of the two lenses beforehand.
enum class Lenses {
  kEach,   ///< nothing
  kAlike,  ///< one focal length for both, and no tangential distortion
};

/// How far corners are from where the rig says they must be, all as rms over the corners of one pair [px].
struct PairError {
  double left = 0, right = 0;  ///< distance from the reprojected corner
  double epipolar = 0;         ///< distance of the rows after rectification
};

struct StereoCalibration {
  StereoRig rig;
  double left_rms = 0, right_rms = 0;  ///< of each camera calibrated by itself [px]
  double rms = 0;  ///< of the rig [px]: distances over the shared corners of both cameras, as OpenCV counts
  EpipolarError epipolar;
  SquareLength square;
  std::vector<PairError> pairs;     ///< in the order given
  std::vector<Estimate> estimates;  ///< of the cameras, then of right_from_left
};

/// The pairs leave a lens open; the message names where on its image the board is missing.
class UndeterminedLens : public InputError {
 public:
  using InputError::InputError;
};

/// Each camera by itself, then all together (OpenCV's stereoCalibrate). Depth limits and the like keep
/// StereoRig's defaults. Throws InputError for fewer than kFewestViews; for a pair that shares fewer than 6
/// corners, or only such in one line (`shows_enough`); for one whose images do not belong together
/// (`torn_pairs`); and for a result that is no usable rig, UndeterminedLens where that is a camera's fault.
StereoCalibration calibrate_stereo(const Board& board, const std::vector<BoardPair>& pairs, int width,
                                   int height, Lenses lenses = Lenses::kEach);

}  // namespace headway::vision
