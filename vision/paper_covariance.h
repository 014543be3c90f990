// The paper's covariance of a point, equation by equation: the reference that the shorter routes are held to.
#pragma once

#include <Eigen/Core>

#include "vision/triangulation.h"

namespace headway::vision {

/// A point in homogeneous coordinates, with the covariance of all four.
struct HomogeneousPoint {
  Eigen::Vector4d position = Eigen::Vector4d::Zero();    ///< Q = w (X, 1), in any scale
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of Q, of rank 3: along Q itself nothing varies

  /// The covariance [m^2] of the point X = (Q1, Q2, Q3) / w (paper, equation 4):
  ///   D Sigma D^T, with D = dX/dQ = [I | -X] / w.
  /// The upper left of `covariance` is not that: it depends on the unit of length.
  Eigen::Matrix3d euclidean_covariance() const;
};

/// Sigma_Q = (J^T S^-1 J)^+ with J = W A the derivative of the four pixel coordinates by Q, W =
/// diag(1/w_left, 1/w_left, 1/w_right, 1/w_right), S = `pixels` [px^2] (paper, equations 2 and 3). A is taken
/// at the pixels where Q appears, so that A Q = 0. The pseudo-inverse leaves out the least singular value,
/// whatever its size: the scale of Q is the one thing that no pixel tells.
HomogeneousPoint with_paper_covariance(const ProjectionMatrix& left, const ProjectionMatrix& right,
                                       const Eigen::Vector4d& position, const Eigen::Matrix4d& pixels);

}  // namespace headway::vision
