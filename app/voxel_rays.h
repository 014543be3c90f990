// One ray through the voxel map: the first surface it meets, and where it enters or leaves unseen space.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "nav/voxel_map.h"

namespace headway::app {

/// A face of a voxel that a ray passes.
struct VoxelFace {
  double t = 0;                         ///< distance from the eye [m]
  int axis = 2;                         ///< the face's normal is along x (0), y (1) or z (2) ...
  int side = 1;                         ///< ... and points this way, towards the eye
  nav::VoxelMap::Index voxel{0, 0, 0};  ///< behind the face
};

struct RayResult {
  static constexpr int kMostVeils = 3;
  std::optional<VoxelFace> surface;
  std::array<VoxelFace, kMostVeils>
      veils;  ///< where the ray passes from empty to unseen space, before the surface
  int veil_count = 0;
};

/// Walks voxel by voxel (Amanatides and Woo), and skips bricks that are empty or unseen as a whole.
class VoxelRays {
 public:
  struct Config {
    Eigen::Vector3d lowest, highest;  ///< the part of the map that is looked at [m]
    /// Surfaces count only when the ray comes to them through empty space: those are the sides that were
    /// seen, and one looks into a room through the backs of its walls.
    bool seen_sides_only = true;
    double gap = 0.4;  ///< unseen space [m] that may lie between the empty space and such a surface
    bool veils = false;
  };
  VoxelRays(const nav::VoxelMap& map, const Config& config);

  /// `direction` has length one; map frame, metres.
  RayResult walk(const Eigen::Vector3d& eye, const Eigen::Vector3d& direction) const;

 private:
  class Walk;
  const nav::VoxelMap& map_;
  Config config_;
  nav::VoxelMap::Index first_, end_;  ///< voxels looked at: first_ <= i < end_
};

}  // namespace headway::app
