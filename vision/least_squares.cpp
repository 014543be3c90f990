#include "vision/least_squares.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace headway::vision {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int kMostRounds = 100;
constexpr double kSettled = 1e-6;  // of the sum of squares

}  // namespace

MatrixXd jacobian(const Residuals& residuals, const VectorXd& x, const VectorXd& steps) {
  MatrixXd j;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const VectorXd step = VectorXd::Unit(x.size(), i) * steps(i);
    const VectorXd slope = (residuals(x + step) - residuals(x - step)) / (2 * steps(i));
    if (i == 0) j.resize(slope.size(), x.size());
    j.col(i) = slope;
  }
  return j;
}

LeastSquares minimise(const Residuals& residuals, VectorXd x, const VectorXd& steps) {
  LeastSquares out;
  out.residuals = residuals(x);
  double damping = 1e-4;
  for (; out.rounds < kMostRounds && !out.settled; ++out.rounds) {
    const MatrixXd j = jacobian(residuals, x, steps);
    out.information = j.transpose() * j;
    const VectorXd gradient = j.transpose() * out.residuals;
    bool better = false;
    while (!better && damping < 1e10) {
      MatrixXd damped = out.information;
      damped.diagonal() += damping * out.information.diagonal() + VectorXd::Constant(x.size(), 1e-12);
      const VectorXd candidate = x - damped.ldlt().solve(gradient);
      VectorXd at_candidate = residuals(candidate);
      const double before = out.residuals.squaredNorm(), after = at_candidate.squaredNorm();
      better = std::isfinite(after) && after < before;
      damping *= better ? 0.1 : 10;
      if (!better) continue;
      out.settled = before - after <= kSettled * before;
      x = candidate;
      out.residuals = std::move(at_candidate);
    }
    if (!better) out.settled = true;
    damping = std::max(damping, 1e-12);
  }
  const MatrixXd j = jacobian(residuals, x, steps);
  out.information = j.transpose() * j;
  out.x = std::move(x);
  return out;
}

}  // namespace headway::vision
