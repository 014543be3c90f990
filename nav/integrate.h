// Puts what one view saw into the voxel map.
//
// Voxels are projected into the range image; no rays are cast. With the range image's uncertainty a voxel is
// emptied only where the surface behind it is more than three sigma away, and hits are spread over half of
// sigma, more where neighbouring pixels err together.
//
// Isolated outliers leave no trace: a point counts only with another pixel of the same surface in its 2x2
// block (where the image is reduced) and two neighbouring samples. One view's full hit (+17) makes an unseen
// voxel occupied. Three views in a row that see a voxel empty undo whatever was known: a miss (-8) leaves
// little of an older past, so that what has gone does not linger, and one wrong view empties no wall. A hit
// leaves little of it too, so that what comes is there at once: the least hit makes any voxel occupied. In a
// view with inlier weights, as matchers give them, matches may be wrong: there a voxel that was long known to
// be empty takes a sure hit, or hits of two views in a row.
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
  /// Voxels are emptied only so many sigma in front of what was measured.
  double free_sigmas = 3;
  /// Hits reach at least this many sigma to both sides of the surface.
  double least_hit_sigmas = 0.5;
  /// They reach so many times what samples err by, as each view shows, up to one sigma. Samples are means
  /// over several pixels: errors of each pixel's own average out, those that neighbours share, as matchers'
  /// do, hardly. Less leaves holes in walls that are far off, more only thickens them.
  double hit_errors = 1.35;
  /// Share of a full hit for the voxel that holds a measured point, however wide sigma is. In a view without
  /// inlier weights such a hit makes any voxel occupied.
  double least_hit = 0.5;
  /// Points with less inlier weight say nothing: a wrong match is off by any amount, and the robot that
  /// stands still sees the same one again and again.
  double least_weight = 0.8;
  /// Neighbours (of 8) that must lie on the same surface; a point with fewer is an outlier.
  int supporters = 2;
  /// Limit of half a hit's depth on surfaces seen at grazing angles, in voxels.
  double longest_hit = 4;
  /// Points in these boxes are the robot itself and say nothing. In the frame that `map_from_body` places.
  std::vector<BodyBox> own_body;

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

/// What one view did.
struct IntegrationStats {
  std::size_t samples = 0;     ///< of the reduced range image, used
  std::size_t rejected = 0;    ///< of it, dropped as outliers or as the robot itself
  std::size_t hits = 0;        ///< voxels seen occupied
  std::size_t misses = 0;      ///< voxels seen empty
  std::size_t first_seen = 0;  ///< voxels that were unseen before
  std::size_t bricks_changed = 0;
};

/// Integrates views and keeps the memory it needs for that, which grows only when a view needs more than all
/// before. The same views in the same order give the same map, to the byte.
class Integrator {
 public:
  /// Throws InputError as IntegrationConfig::validate.
  explicit Integrator(const IntegrationConfig& config = {});
  ~Integrator();
  Integrator(Integrator&&) noexcept;
  Integrator& operator=(Integrator&&) noexcept;

  /// `view` as seen from `map_from_camera` (optical frame) at `stamp`. Untouched stay the voxels behind a
  /// surface, those nearer than the view's near or farther than its far, and those of pixels that are NaN, on
  /// the robot itself, or outliers. Throws Error when the view's images do not have the camera's size or the
  /// pose is not finite.
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
