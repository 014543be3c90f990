// From disparities or depths to points with their uncertainty.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>

#include "hal/frame.h"
#include "vision/disparity.h"
#include "vision/range_view.h"
#include "vision/rectified_rig.h"

namespace headway::vision {

/// Beyond this sigma_d / d the error of depth is no longer first order, and the point is not used.
constexpr double kLargestRelativeSigma = 0.1;

/// Z = f B / d, sigma_Z = Z sigma_d / d. Uses `disparity.sigma` where it is filled, else the rig's sigma;
/// hands `disparity.weight` on. Points nearer than `near` or with sigma_d / d > 0.1 are dropped. Points
/// farther than `far` are kept: their rays are empty up to `far`, which the map wants to know. `view` is
/// overwritten; its memory is reused.
void range_view(const DisparityImage& disparity, const RectifiedRig& rig, RangeView& view);
RangeView range_view(const DisparityImage& disparity, const RectifiedRig& rig);

/// The error of a depth that a stereo rig measured: sigma_Z = Z^2 / focal_baseline * disparity_sigma.
struct StereoDepthSigma {
  double focal_baseline = 0;      ///< [px m]
  double disparity_sigma = 0.25;  ///< [px]
};
/// The error of a depth camera: sigma_Z = constant + quadratic Z^2.
struct DepthCameraSigma {
  double constant = 0.001;    ///< [m]
  double quadratic = 0.0019;  ///< [1/m]
};
using DepthSigma = std::variant<StereoDepthSigma, DepthCameraSigma>;

/// The same from measured depths. Depths that are not finite or not positive are "nothing measured", and so
/// are depths below `near` or with sigma_Z / Z > 0.1. An image of another size than the camera's gives an
/// empty view (all NaN).
RangeView range_view(const hal::DepthFrame& frame, const PinholeCamera& camera, double near, double far,
                     const DepthSigma& sigma);

/// A point seen by two cameras in any arrangement.
struct UncertainPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m^2]
  double residual = 0;  ///< rms distance [px] of the pixels from the point's; matches beyond 0.5 are doubtful
};

using ProjectionMatrix = Eigen::Matrix<double, 3, 4>;  ///< pixel (homogeneous) from point (homogeneous)

/// The rows of A: A Q = 0 is what two pixels say of the point Q (homogeneous; paper, equation 1).
Eigen::Matrix4d pixel_equations(const ProjectionMatrix& left, const ProjectionMatrix& right,
                                const Eigen::Vector2d& in_left, const Eigen::Vector2d& in_right);

/// Triangulates by the direct linear transform (the least singular vector of W A), then
/// Sigma = (J^T S^-1 J)^-1 with J the 4x3 derivative of the four pixel coordinates and S = `sigma_px`^2 I
/// (paper, equations 2 to 4; one 3x3 inverse in place of the 4x4 pseudo-inverse of `with_paper_covariance`,
/// which gives the same). Lengths are counted in baselines, so that neither the unit nor the scale of the
/// matrices matters. Nothing when the rays are nearly parallel, the point lies behind a camera, the cameras
/// stand in one place, or a number is not finite.
std::optional<UncertainPoint> triangulate(const ProjectionMatrix& left, const ProjectionMatrix& right,
                                          const Eigen::Vector2d& in_left, const Eigen::Vector2d& in_right,
                                          double sigma_px);

/// The covariance alone, of a point at `position`, whose four pixel coordinates have covariance `pixels`
/// [px^2].
Eigen::Matrix3d covariance(const ProjectionMatrix& left, const ProjectionMatrix& right,
                           const Eigen::Vector3d& position, const Eigen::Matrix4d& pixels);

}  // namespace headway::vision
