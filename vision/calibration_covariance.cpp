#include "vision/calibration_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "vision/board_pose.h"
#include "vision/least_squares.h"

namespace headway::vision {

namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPoseStep = 1e-5;  // [rad] and [m]

VectorXd joined(const VectorXd& a, const VectorXd& b) {
  VectorXd out(a.size() + b.size());
  out << a, b;
  return out;
}

VectorXd pair_residuals(const StereoRig& rig, const Isometry3d& left_from_board, const Board& board,
                        const SharedCorners& pair) {
  return joined(reprojection_residuals(rig.left, left_from_board, board, pair.left),
                reprojection_residuals(rig.right, rig.right_from_left * left_from_board, board, pair.right));
}

VectorXd pose_steps() { return VectorXd::Constant(6, kPoseStep); }

/// What one pair says about the parameters when nothing is known of its board.
MatrixXd information_of(const StereoRig& rig, const Isometry3d& left_from_board, const Board& board,
                        const SharedCorners& pair, const std::vector<RigParameter>& parameters) {
  const auto changed = [&](const VectorXd& x) {
    StereoRig other = rig;
    for (std::size_t i = 0; i < parameters.size(); ++i)
      parameters[i].add(other, x(static_cast<Eigen::Index>(i)));
    return pair_residuals(other, left_from_board, board, pair);
  };
  const auto shifted = [&](const VectorXd& x) {
    return pair_residuals(rig, moved(left_from_board, x), board, pair);
  };
  VectorXd steps(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    steps(static_cast<Eigen::Index>(i)) = parameters[i].step;
  const MatrixXd of_rig = jacobian(changed, VectorXd::Zero(steps.size()), steps);
  const MatrixXd of_pose = jacobian(shifted, VectorXd::Zero(6), pose_steps());
  const MatrixXd cross = of_pose.transpose() * of_rig;
  return of_rig.transpose() * of_rig -
         cross.transpose() * (of_pose.transpose() * of_pose).ldlt().solve(cross);
}

/// Square roots of the diagonal of the inverse; infinite along directions that hold no information.
VectorXd deviations(const MatrixXd& information) {
  const VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scale.asDiagonal() * information * scale.asDiagonal());
  VectorXd out = VectorXd::Zero(information.rows());
  for (Eigen::Index k = 0; k < information.rows(); ++k) {
    const double value = solver.eigenvalues()(k);
    const VectorXd direction = solver.eigenvectors().col(k);
    for (Eigen::Index i = 0; i < out.size(); ++i) {
      if (value > 1e-12) out(i) += direction(i) * direction(i) / value;
      if (value <= 1e-12 && std::abs(direction(i)) > 1e-3) out(i) = std::numeric_limits<double>::infinity();
    }
  }
  return out.cwiseSqrt().cwiseProduct(scale);
}

}  // namespace

double RigFit::squares() const {
  double sum = 0;
  for (std::size_t i = 0; i < left.size(); ++i) sum += left[i].squaredNorm() + right[i].squaredNorm();
  return sum;
}

double RigFit::count() const {
  double n = 0;
  for (std::size_t i = 0; i < left.size(); ++i) n += static_cast<double>(left[i].size() + right[i].size());
  return n;
}

RigFit fit_boards(const StereoRig& rig, const Board& board, const std::vector<SharedCorners>& pairs) {
  RigFit fit;
  for (const SharedCorners& pair : pairs) {
    const Isometry3d guess = camera_from_board(rig.left, board, pair.left);
    const auto residuals = [&](const VectorXd& x) {
      return pair_residuals(rig, moved(guess, x), board, pair);
    };
    const LeastSquares best = minimise(residuals, VectorXd::Zero(6), pose_steps());
    fit.left_from_board.push_back(moved(guess, best.x));
    fit.left.push_back(best.residuals.head(2 * static_cast<Eigen::Index>(pair.left.size())));
    fit.right.push_back(best.residuals.tail(2 * static_cast<Eigen::Index>(pair.right.size())));
  }
  return fit;
}

std::vector<Estimate> estimates_of(const StereoRig& rig, const Board& board,
                                   const std::vector<SharedCorners>& pairs, const RigFit& fit,
                                   const std::vector<RigParameter>& parameters) {
  const auto n = static_cast<Eigen::Index>(parameters.size());
  MatrixXd information = MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    information += information_of(rig, fit.left_from_board[i], board, pairs[i], parameters);
  const double free = static_cast<double>(n) + 6 * static_cast<double>(pairs.size());
  const double variance = fit.squares() / std::max(1.0, fit.count() - free);
  const VectorXd sigma = std::sqrt(variance) * deviations(information);
  std::vector<Estimate> out;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const RigParameter& p = parameters[i];
    out.push_back({p.name, p.value(rig), sigma(static_cast<Eigen::Index>(i)), p.unit});
  }
  return out;
}

}  // namespace headway::vision
