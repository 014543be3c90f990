#include "vision/paper_covariance.h"

#include <Eigen/Dense>

namespace headway::vision {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector4d;

namespace {

constexpr int kRank = 3;

Vector2d pixel_of(const ProjectionMatrix& p, const Vector4d& q) { return (p * q).hnormalized(); }

Matrix4d pseudo_inverse(const Matrix4d& m) {
  const Eigen::JacobiSVD<Matrix4d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const auto inverse = svd.singularValues().head<kRank>().cwiseInverse();
  return svd.matrixV().leftCols<kRank>() * inverse.asDiagonal() * svd.matrixU().leftCols<kRank>().transpose();
}

}  // namespace

Matrix3d HomogeneousPoint::euclidean_covariance() const {
  Eigen::Matrix<double, 3, 4> d;
  d << Matrix3d::Identity(), -position.hnormalized();
  d /= position.w();
  return d * covariance * d.transpose();
}

HomogeneousPoint with_paper_covariance(const ProjectionMatrix& left, const ProjectionMatrix& right,
                                       const Vector4d& position, const Matrix4d& pixels) {
  const double w_left = left.row(2).dot(position), w_right = right.row(2).dot(position);
  const Vector4d weights(1 / w_left, 1 / w_left, 1 / w_right, 1 / w_right);
  const Matrix4d j = weights.asDiagonal() *
                     pixel_equations(left, right, pixel_of(left, position), pixel_of(right, position));
  return {position, pseudo_inverse(j.transpose() * pixels.inverse() * j)};
}

}  // namespace headway::vision
