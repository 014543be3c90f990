// How sure a stereo calibration is: the standard deviations of its parameters, from the corners' residuals.
// The board's poses, which nobody asks for, are estimated along and marginalised out.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "vision/board.h"
#include "vision/rig.h"

namespace headway::vision {

/// A number that a calibration found. Names are those of the members of StereoRig and CameraIntrinsics
/// ("left.fx"), and of the transform's parts ("right_from_left.x", "right_from_left.turn_x").
struct Estimate {
  std::string name;
  double value = 0, sigma = 0;  ///< with its standard deviation, in the same unit
  std::string unit;
};

/// A number of a rig that the calibration was free to choose.
struct RigParameter {
  std::string name, unit;
  std::function<double(const StereoRig&)> value;
  std::function<void(StereoRig&, double)> add;
  double step = 0;  ///< for derivatives, in the parameter's unit
};

/// The board in each pair as the rig sees it best, and what remains.
struct RigFit {
  std::vector<Eigen::Isometry3d> left_from_board;
  std::vector<Eigen::VectorXd> left, right;  ///< residuals [px], x and y of each corner in turn

  double squares() const;  ///< sum of all squared residuals
  double count() const;    ///< number of residuals
};
RigFit fit_boards(const StereoRig& rig, const Board& board, const std::vector<SharedCorners>& pairs);

/// Linear in the residuals at the optimum: covariance = variance of a residual times (J^T J)^-1, with the
/// boards' poses eliminated by the Schur complement. Infinite where the pairs say nothing of a parameter.
std::vector<Estimate> estimates_of(const StereoRig& rig, const Board& board,
                                   const std::vector<SharedCorners>& pairs, const RigFit& fit,
                                   const std::vector<RigParameter>& parameters);

}  // namespace headway::vision
