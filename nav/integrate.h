// Puts what one view saw into the voxel map.
//
// Voxels are projected into the range image; no rays are cast. With the range image's covariance a voxel is
// emptied only where the surface behind it is more than three sigma away, and a hit is spread over plus and
// minus one sigma.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <vector>

#include "hal/time.h"
#include "nav/voxel_map.h"
#include "vision/range_view.h"

namespace headway::nav {

/// A box of the robot's own body, in the body's frame [m].
struct BodyBox {
  Eigen::Vector3d lowest, highest;
};

struct IntegrationConfig {
  double free_sigmas = 3;  ///< empty only this many sigma in front of what was measured
  double hit_sigmas = 1;   ///< hits reach this many sigma to both sides
  double least_hit =
      0.5;  ///< of a full hit, for the voxel that holds a measured point, however wide sigma is
  int supporters =
      2;  ///< neighbours (of 8) that must lie on the same surface; a point with fewer is an outlier
  double longest_hit = 4;  ///< voxels: limit of half a hit's depth on surfaces seen at grazing angles
  /// Points in these boxes are the robot itself and say nothing. In the frame that `map_from_body` places.
  std::vector<BodyBox> own_body;

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

/// What one view did.
struct IntegrationStats {
  std::size_t samples = 0;   ///< points of the (reduced) range image that were used
  std::size_t rejected = 0;  ///< outliers, and points on the robot itself
  std::size_t hits = 0,
              misses = 0;  ///< voxels made more, and less, likely to be occupied (at the clamps: unchanged)
  std::size_t first_seen = 0;  ///< voxels that were unseen before
  std::size_t bricks_changed = 0;
};

/// Integrates views and keeps the memory it needs for that; after the first view of a size nothing is
/// allocated. The same views in the same order give the same map, to the byte.
class Integrator {
 public:
  /// Throws InputError as IntegrationConfig::validate.
  explicit Integrator(const IntegrationConfig& config = {});
  ~Integrator();
  Integrator(Integrator&&) noexcept;
  Integrator& operator=(Integrator&&) noexcept;

  /// `view` as seen from `map_from_camera` (optical frame) at `stamp`. Pixels that are NaN, not within the
  /// view's near and far, on the robot itself, or outliers leave their voxels untouched, as does all behind a
  /// surface.
  IntegrationStats integrate(VoxelMap& map, const vision::RangeView& view,
                             const Eigen::Isometry3d& map_from_camera, Time stamp,
                             const Eigen::Isometry3d& map_from_body = Eigen::Isometry3d::Identity());

 private:
  struct Scratch;
  IntegrationConfig config_;
  std::unique_ptr<Scratch> scratch_;
};

/// One view with fresh memory; for tools and tests.
IntegrationStats integrate(VoxelMap& map, const vision::RangeView& view,
                           const Eigen::Isometry3d& map_from_camera, Time stamp,
                           const IntegrationConfig& config = {});

}  // namespace headway::nav
