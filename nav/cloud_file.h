// Uncertain points as a PLY file: position and the covariance in the map frame, coloured by uncertainty.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <filesystem>
#include <vector>

#include "vision/range_view.h"

namespace headway::nav {

struct CloudFileConfig {
  double sharp = 0.005,
         blurred = 0.10;  ///< largest standard deviation [m] shown blue, and red (logarithmic between)
  int every = 1;          ///< take each n-th pixel along both axes
};

/// A point with its covariance in the map frame.
struct CloudPoint {
  Eigen::Vector3f position;      ///< [m]
  float xx, xy, xz, yy, yz, zz;  ///< covariance [m^2]
};

/// Collects the points of views and writes them as one binary PLY: x y z, red green blue, cov_xx .. cov_zz.
class CloudFile {
 public:
  explicit CloudFile(const CloudFileConfig& config = {}) : config_(config) {}
  /// Adds the points of a view that lie within its near and far.
  void add(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera);
  std::size_t size() const { return points_.size(); }
  const std::vector<CloudPoint>& points() const { return points_; }
  /// The file appears whole or not at all. Throws as write_whole does.
  void write(const std::filesystem::path& file) const;

 private:
  CloudFileConfig config_;
  std::vector<CloudPoint> points_;
};

}  // namespace headway::nav
