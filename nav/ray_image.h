// How far a look would reach: along each ray of a coarse image, the depth at which something ends it.
//
// Lengths are in any one unit; "camera" is the optical frame (z forward), and depths are measured along z.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace headway::nav {

/// Ray (u, v) goes from the camera through (x0 + (u + 0.5) step, y0 + (v + 0.5) step, 1).
struct RayGrid {
  int width = 0, height = 0;
  float x0 = 0, y0 = 0, step = 0;
};

/// Rays [u0, u1) x [v0, v1).
struct RayRect {
  int u0 = 0, v0 = 0, u1 = 0, v1 = 0;
  bool empty() const { return u0 >= u1 || v0 >= v1; }
};

struct ReachBounds {
  float least = 0, most = 0;
};

class RayImage {
 public:
  explicit RayImage(const RayGrid& grid);

  /// A new look from a camera turned by `map_from_camera`: no ray ends yet.
  void begin(const Eigen::Matrix3f& map_from_camera);
  /// Ends rays where they, or any corner of their pixels, enter a convex piece of space n x + d >= 0 (rows
  /// (n, d), camera frame).
  void end_inside(std::span<const Eigen::Vector4f> rows);
  /// Ends rays where they enter a box. `low` and `high` are its corners seen from the camera along the map's
  /// axes; `rect` holds at least the rays that meet it.
  void end_at_box(const Eigen::Vector3f& low, const Eigen::Vector3f& high, const RayRect& rect);
  /// Makes ready for `bounds`.
  void settle();

  /// The rays that may meet a box around `centre` that reaches `half` along the camera's axes; all of the
  /// image when the camera may lie in it.
  RayRect rect(const Eigen::Vector3f& centre, const Eigen::Vector3f& half) const;
  /// Bounds of the reach in at least that part of the image, which must not be empty.
  ReachBounds bounds(const RayRect& rect) const;

  const RayGrid& grid() const { return grid_; }
  /// Depths; row v begins at v * stride().
  const std::vector<float>& reach() const { return reach_; }
  int stride() const { return stride_; }

 private:
  RayGrid grid_;
  int stride_, tiles_across_, tiles_down_;
  std::vector<float> inverse_x_, inverse_y_, inverse_z_;  ///< of each ray's direction along the map's axes
  std::vector<float> reach_;
  std::vector<ReachBounds> tiles_;
};

}  // namespace headway::nav
