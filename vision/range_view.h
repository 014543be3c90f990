// What one look gives to the map: for each pixel of the left rectified image, how far, and how sure.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace headway::vision {

/// A rectified (distortion-free, square-pixel) camera. Pixel centres lie at whole numbers.
struct PinholeCamera {
  int width = 0, height = 0;
  double focal = 0, cx = 0, cy = 0;  ///< [px]

  /// The point at depth `z` [m] on the ray of pixel (u, v), in the optical frame.
  Eigen::Vector3d point(double u, double v, double z) const {
    return {(u - cx) / focal * z, (v - cy) / focal * z, z};
  }
};

/// A range image with the uncertainty of each point. All in the left rectified camera's optical frame.
struct RangeView {
  PinholeCamera camera;
  /// Depths Z [m] that the sensor is trusted for. No point is nearer than `near`; one may be farther than
  /// `far`, which tells no more than that its ray is empty up to there.
  double near = 0, far = 0;
  std::vector<float> depth;        ///< Z [m], row-major height x width; NaN where nothing was measured
  std::vector<float> sigma_depth;  ///< standard deviation of Z [m], same layout; NaN where depth is
  /// Probability 0..1 that the point is no outlier, same layout; NaN where depth is. Empty: 1 everywhere.
  std::vector<float> weight = {};

  static constexpr double kPixelSigma =
      0.28867513459481287;  ///< 1/sqrt(12): where in its pixel the point lies

  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u);
  }

  /// Covariance [m^2] of the point at pixel (u, v), for a rectified rig (paper, equations 2 to 4, with the
  /// error of the disparity and the place inside the pixel independent):
  ///   Sigma = (Z/f)^2 diag(su^2, su^2, 0) + (sigma_Z/Z)^2 P P^T,   sigma_Z/Z = sigma_d/d.
  Eigen::Matrix3d covariance(int u, int v) const {
    const double z = static_cast<double>(depth[index(u, v)]);
    const double s = static_cast<double>(sigma_depth[index(u, v)]) / z;
    const Eigen::Vector3d p = camera.point(u, v, z);
    const double lateral = z / camera.focal * kPixelSigma;
    Eigen::Matrix3d sigma = s * s * p * p.transpose();
    sigma(0, 0) += lateral * lateral;
    sigma(1, 1) += lateral * lateral;
    return sigma;
  }
};

}  // namespace headway::vision
