#include "vision/paper_covariance.h"

#include <Eigen/Dense>
#include <cmath>

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

Matrix4d pixel_equations(const ProjectionMatrix& left, const ProjectionMatrix& right, const Vector2d& in_left,
                         const Vector2d& in_right) {
  Matrix4d a;
  a.row(0) = in_left.x() * left.row(2) - left.row(0);
  a.row(1) = in_left.y() * left.row(2) - left.row(1);
  a.row(2) = in_right.x() * right.row(2) - right.row(0);
  a.row(3) = in_right.y() * right.row(2) - right.row(1);
  return a;
}

HomogeneousPoint with_paper_covariance(const ProjectionMatrix& left, const ProjectionMatrix& right,
                                       const Vector4d& position, const Matrix4d& pixels) {
  const double w_left = left.row(2).dot(position), w_right = right.row(2).dot(position);
  const Vector4d weights(1 / w_left, 1 / w_left, 1 / w_right, 1 / w_right);
  const Matrix4d j = weights.asDiagonal() *
                     pixel_equations(left, right, pixel_of(left, position), pixel_of(right, position));
  return {position, pseudo_inverse(j.transpose() * pixels.inverse() * j)};
}

std::optional<UncertainPoint> triangulate_as_the_paper(const ProjectionMatrix& left,
                                                       const ProjectionMatrix& right, const Vector2d& in_left,
                                                       const Vector2d& in_right, double sigma_px) {
  const Matrix4d a = pixel_equations(left, right, in_left, in_right);
  Vector4d q = Eigen::JacobiSVD<Matrix4d>(a, Eigen::ComputeFullV).matrixV().col(3);
  if (std::abs(q.w()) < 1e-9 * q.norm()) return std::nullopt;  // a direction, not a point
  q /= q.w();
  if (!(left.row(2).dot(q) > 0) || !(right.row(2).dot(q) > 0)) return std::nullopt;  // behind a camera
  UncertainPoint point;
  point.position = q.head<3>();
  point.covariance = with_paper_covariance(left, right, q, sigma_px * sigma_px * Matrix4d::Identity())
                         .euclidean_covariance();
  point.residual = std::sqrt(
      ((pixel_of(left, q) - in_left).squaredNorm() + (pixel_of(right, q) - in_right).squaredNorm()) / 4);
  return point;
}

}  // namespace headway::vision
