#include "vision/triangulation.h"

#include <Eigen/Dense>
#include <cmath>

namespace headway::vision {

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

void clear(RangeView& view, const PinholeCamera& camera, double near, double far) {
  const auto size = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  view.camera = camera;
  view.near = near, view.far = far;
  view.depth.assign(size, kNone);
  view.sigma_depth.assign(size, kNone);
  view.weight.clear();
}

double sigma_at(const StereoDepthSigma& s, double z) { return z * z / s.focal_baseline * s.disparity_sigma; }
double sigma_at(const DepthCameraSigma& s, double z) { return s.constant + s.quadratic * z * z; }

Vector3d centre_of(const ProjectionMatrix& p) { return -p.leftCols<3>().inverse() * p.col(3); }

// The same camera with lengths in `unit` [m], scaled so that its third row gives the depth.
ProjectionMatrix in_units(ProjectionMatrix p, double unit) {
  p.leftCols<3>() *= unit;
  return p / std::copysign(p.row(2).head<3>().norm(), p.leftCols<3>().determinant());
}

Vector2d pixel_of(const ProjectionMatrix& p, const Vector3d& x) {
  return (p * x.homogeneous()).hnormalized();
}

// Derivative of the pixel by the point.
Eigen::Matrix<double, 2, 3> jacobian(const ProjectionMatrix& p, const Vector3d& x) {
  const Vector3d h = p * x.homogeneous();
  Eigen::Matrix<double, 2, 3> j;
  j.row(0) = (p.row(0) - h.x() / h.z() * p.row(2)).head<3>() / h.z();
  j.row(1) = (p.row(1) - h.y() / h.z() * p.row(2)).head<3>() / h.z();
  return j;
}

}  // namespace

void range_view(const DisparityImage& disparity, const RectifiedRig& rig, RangeView& view) {
  clear(view, rig.camera, rig.nearest, rig.farthest);
  if (disparity.values.size() != view.depth.size()) return;
  const bool weighted = !disparity.weight.empty();
  if (weighted) view.weight.assign(view.depth.size(), kNone);
  const auto focal_baseline = static_cast<float>(rig.camera.focal * rig.baseline);
  const auto offset = static_cast<float>(rig.disparity_offset), near = static_cast<float>(rig.nearest);
  for (std::size_t i = 0; i < view.depth.size(); ++i) {
    const float d = disparity.values[i] + offset;
    const float sigma =
        disparity.sigma.empty() ? static_cast<float>(rig.disparity_sigma) : disparity.sigma[i];
    if (!(sigma <= static_cast<float>(kLargestRelativeSigma) * d)) continue;  // also where d is NaN
    const float z = focal_baseline / d;
    if (z < near) continue;
    view.depth[i] = z;
    view.sigma_depth[i] = z * sigma / d;
    if (weighted) view.weight[i] = disparity.weight[i];
  }
}

RangeView range_view(const DisparityImage& disparity, const RectifiedRig& rig) {
  RangeView view;
  range_view(disparity, rig, view);
  return view;
}

RangeView range_view(const hal::DepthFrame& frame, const PinholeCamera& camera, double near, double far,
                     const DepthSigma& sigma) {
  RangeView view;
  clear(view, camera, near, far);
  if (frame.width != camera.width || frame.height != camera.height || frame.depth.size() != view.depth.size())
    return view;
  for (std::size_t i = 0; i < view.depth.size(); ++i) {
    const double z = static_cast<double>(frame.depth[i]);
    if (!std::isfinite(z) || z < near || z <= 0) continue;
    const double s = std::visit([z](const auto& model) { return sigma_at(model, z); }, sigma);
    if (!(s <= kLargestRelativeSigma * z)) continue;
    view.depth[i] = frame.depth[i];
    view.sigma_depth[i] = static_cast<float>(s);
  }
  return view;
}

Matrix3d covariance(const ProjectionMatrix& left, const ProjectionMatrix& right, const Vector3d& position,
                    const Matrix4d& pixels) {
  Eigen::Matrix<double, 4, 3> j;
  j << jacobian(left, position), jacobian(right, position);
  return (j.transpose() * pixels.inverse() * j).inverse();
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

std::optional<UncertainPoint> triangulate(const ProjectionMatrix& left, const ProjectionMatrix& right,
                                          const Vector2d& in_left, const Vector2d& in_right,
                                          double sigma_px) {
  const double baseline = (centre_of(right) - centre_of(left)).norm();
  if (!(baseline > 0)) return std::nullopt;
  const ProjectionMatrix l = in_units(left, baseline), r = in_units(right, baseline);
  const Matrix4d a = pixel_equations(l, r, in_left, in_right);
  if (!a.allFinite()) return std::nullopt;
  // Without the weights 1/w the far camera would count more; they follow from the point, so it takes a second
  // pass.
  constexpr int kPasses = 3;
  double w_left = 1, w_right = 1;
  Vector4d q;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Vector4d weights(1 / w_left, 1 / w_left, 1 / w_right, 1 / w_right);
    q = Eigen::JacobiSVD<Matrix4d>(weights.asDiagonal() * a, Eigen::ComputeFullV).matrixV().col(3);
    if (!(std::abs(q.w()) > 1e-9 * q.norm())) return std::nullopt;  // a direction, not a point
    q /= q.w();
    w_left = l.row(2).dot(q), w_right = r.row(2).dot(q);
    if (!(w_left > 0) || !(w_right > 0)) return std::nullopt;  // behind a camera
  }
  UncertainPoint point;
  point.position = baseline * q.head<3>();
  point.covariance = covariance(left, right, point.position, sigma_px * sigma_px * Matrix4d::Identity());
  point.residual = std::sqrt(((pixel_of(left, point.position) - in_left).squaredNorm() +
                              (pixel_of(right, point.position) - in_right).squaredNorm()) /
                             4);
  const double distance = (point.position - centre_of(left)).norm();
  const double largest =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(point.covariance, Eigen::EigenvaluesOnly).eigenvalues()(2);
  if (!(largest <= std::pow(kLargestRelativeSigma * distance, 2)))
    return std::nullopt;  // nearly parallel rays
  return point;
}

}  // namespace headway::vision
