// One calibrated camera: where a point in space falls in its image, and the ray that a pixel looks along.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace headway::vision {

/// How a lens bends rays, with the formulas and the coefficients' names of OpenCV 4's calib3d.
enum class LensModel {
  kRadialTangential,  ///< k1 k2 p1 p2 k3: ROS "plumb_bob", Kalibr "radtan", EuRoC "radial-tangential"
  kRational,          ///< k1 to k6, p1 p2: ROS "rational_polynomial"
  kEquidistant,       ///< k1 to k4, fisheye lenses: OpenCV's cv::fisheye, ROS and Kalibr "equidistant"
};

/// The names of its coefficients in OpenCV's order, for files and messages.
const char* coefficient_names(LensModel lens);

/// Pixel centres lie at whole numbers, (0, 0) is the centre of the upper left pixel. Coefficients that the
/// model does not have are not looked at.
struct CameraIntrinsics {
  int width = 0, height = 0;              ///< [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  double k4 = 0, k5 = 0, k6 = 0;
  LensModel lens = LensModel::kRadialTangential;

  /// False for an ideal pinhole.
  bool distorts() const;
  /// The pixel that a point in the camera's optical frame [m] falls on. Needs z > 0; an equidistant lens sees
  /// behind itself and takes any point but the origin.
  Eigen::Vector2d project(const Eigen::Vector3d& point) const;
  /// The ray (length 1) that a pixel looks along, so that `project` leads back to the pixel to 1e-9 focal
  /// lengths. Nothing where no ray does: outside the image circle, where the lens's radial curve has turned
  /// back.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;
};

}  // namespace headway::vision
