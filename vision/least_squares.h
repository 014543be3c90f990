// Non-linear least squares over a few parameters: Levenberg and Marquardt's method with derivatives by
// central differences. For calibrations, not for cycles.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace headway::vision {

/// Residuals at x; always the same number of them.
using Residuals = std::function<Eigen::VectorXd(const Eigen::VectorXd& x)>;

/// d residuals / d x, by central differences of the given steps (one per parameter, in its unit).
Eigen::MatrixXd jacobian(const Residuals& residuals, const Eigen::VectorXd& x, const Eigen::VectorXd& steps);

struct LeastSquares {
  Eigen::VectorXd x;
  Eigen::VectorXd residuals;    ///< at x
  Eigen::MatrixXd information;  ///< J^T J at x: the inverse covariance where residuals have unit variance
  int rounds = 0;
  bool settled = false;  ///< no step made the sum of squares smaller by more than a millionth
};

/// Minimises the sum of squares from `x` on.
LeastSquares minimise(const Residuals& residuals, Eigen::VectorXd x, const Eigen::VectorXd& steps);

}  // namespace headway::vision
