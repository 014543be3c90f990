// A range image made ready for the map: fewer samples, without outliers, each with the plane of its surface
// and the thresholds that tell a voxel in front of it from one on it and one behind.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/integrate.h"
#include "nav/inverse_depth.h"
#include "vision/range_view.h"

namespace headway::nav {

/// One sample. A point Q of the camera's frame lies at r = n.Q times the depth of the surface on its ray.
struct RangeSample {
  float nx = 0, ny = 0, nz = 0;  ///< the surface's plane n.P = 1 [1/m]
  float free = 0;                ///< empty where r is less; 0 where nothing is known
  float half = -2;               ///< hit where |r - 1| is at most this; negative where nothing is known
  std::int32_t hit = 0;          ///< log-odds of such a hit
};

/// What a rectangle of samples says at the most: for whole bricks.
struct DepthBounds {
  float free = 0;  ///< every voxel in it that is nearer [m] is empty
  float back = 0;  ///< every voxel in it that is farther [m] is behind the surface
};

class RangeSamples {
 public:
  /// Takes a view in. `resolution` is a voxel's edge [m].
  void take(const vision::RangeView& view, const IntegrationConfig& config, double resolution,
            const Eigen::Matrix3d& map_from_camera, const Eigen::Isometry3d& body_from_camera);

  /// Of the reduced image: u = focal() X/Z + cx(); sample centres lie at whole numbers.
  int width() const { return image_.width; }
  int height() const { return image_.height; }
  float focal() const { return focal_; }
  float cx() const { return cx_; }
  float cy() const { return cy_; }
  /// The camera's image covers -0.5 <= u < end_u(), -0.5 <= v < end_v().
  float end_u() const { return end_u_; }
  float end_v() const { return end_v_; }

  const RangeSample& at(int x, int y) const { return samples_[sample(x, y)]; }
  /// Inverse depth and its standard deviation [1/m]; 0 where nothing is known.
  float inverse_depth(int x, int y) const { return image_.w[image_.index(x, y)]; }
  float inverse_sigma(int x, int y) const { return image_.sigma[image_.index(x, y)]; }
  /// Beside a surface of another depth: what is thinner than a voxel may end here.
  bool at_edge(int x, int y) const { return edge_[sample(x, y)] != 0; }

  /// Over samples x0..x1, y0..y1 (inclusive, of the image), or somewhat more.
  DepthBounds bounds(int x0, int y0, int x1, int y1) const;
  /// Nothing is said about voxels farther than this [m]: the view's far, or behind all surfaces.
  float farthest() const { return farthest_; }

  std::size_t used() const { return used_; }
  std::size_t rejected() const { return rejected_; }

 private:
  static constexpr int kTile = 4;  ///< samples along the edge of a tile of bounds

  void reduce(const vision::RangeView& view, float least_weight, double resolution);
  void forget_own_body(const std::vector<BodyBox>& boxes, const Eigen::Isometry3d& body_from_camera);
  void describe(int x, int y, const IntegrationConfig& config, float resolution,
                const Eigen::Matrix3f& map_from_camera);
  void add_to_tile(int x, int y, const RangeSample& s, float w);

  std::size_t sample(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) + static_cast<std::size_t>(x);
  }
  std::size_t tile(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(tiles_x_) + static_cast<std::size_t>(x);
  }

  float focal_ = 0, cx_ = 0, cy_ = 0, end_u_ = 0, end_v_ = 0;
  float farthest_ = 0;
  int tiles_x_ = 0;
  std::size_t used_ = 0, rejected_ = 0;
  InverseDepthImage full_, half_, rough_, image_;  ///< at full and half size; as reduced; smoothed
  std::vector<RangeSample> samples_;
  std::vector<DepthBounds> tiles_;
  std::vector<std::uint8_t> edge_;
};

}  // namespace headway::nav
