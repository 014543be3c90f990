// Every pixel's point and covariance at once, in planes, as fast as the memory takes them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "vision/disparity.h"
#include "vision/range_view.h"
#include "vision/rectified_rig.h"

namespace headway::vision {

/// The points of one image in the rectified left camera's optical frame, one plane per quantity, each
/// row-major height x width. NaN where there is no point; the weight is 0 there.
class DensePoints {
 public:
  enum Plane { kX, kY, kZ, kXX, kXY, kXZ, kYY, kYZ, kZZ, kWeight, kPlanes };

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t size() const { return size_; }  ///< pixels in a plane

  /// X, Y, Z [m]; the covariance's XX .. ZZ [m^2]; how likely the match is no gross error, 0..1.
  std::span<const float> operator[](Plane plane) const { return {start_of(plane), size_}; }
  std::span<float> operator[](Plane plane) { return {const_cast<float*>(start_of(plane)), size_}; }

  /// Allocates only where the size has grown; what was there is lost.
  void resize(int width, int height);

 private:
  const float* start_of(Plane plane) const { return memory_.data() + first_ + plane * stride_; }

  int width_ = 0, height_ = 0;
  std::size_t size_ = 0, first_ = 0, stride_ = 0;
  std::vector<float> memory_;
};

/// Which errors are independent of each other.
enum class PixelErrors {
  /// The place inside the left pixel (1/sqrt(12) px both ways) and the disparity (sigma_d):
  ///   Sigma = (Z/f)^2 diag(su^2, su^2, 0) + (sigma_d/d)^2 P P^T, as RangeView::covariance.
  kPlaceAndDisparity,
  /// All four pixel coordinates with s = sigma_d / sqrt(2), as the paper has it (equation 3):
  ///   Sigma = (Z/f)^2 s^2 (ex ex^T + ey ey^T / 2) - (Z s^2/(f d)) (ex P^T + P ex^T) + 2 (s/d)^2 P P^T.
  kFourCoordinates,
};

/// Z = f B / d, X = (u - cx) Z / f, Y = (v - cy) Z / f, and the covariance. Uses `disparity.sigma` where it
/// is filled, else the rig's sigma. `weight` is passed through; where it is empty, each point has weight 1.
/// There is a point where `range_view` of the same disparities has one. An image or a weight of another size
/// than the camera's gives no point at all. Single precision: good to a few millionths of each standard
/// deviation.
void dense_points(const DisparityImage& disparity, std::span<const float> weight, const RectifiedRig& rig,
                  PixelErrors errors, DensePoints& points);

/// The same from a range image, whatever measured it; its errors are kPlaceAndDisparity.
void dense_points(const RangeView& view, std::span<const float> weight, DensePoints& points);

}  // namespace headway::vision
