// What a look from somewhere would show: the unseen voxels of its field up to the first obstacle.
//
// From the occupied voxels a coarse range image is predicted, one ray per voxel's width at the far end of the
// field. The unseen voxels are held against it as the integrator holds a map against a real range image:
// whole bricks by their counts, voxel by voxel only where the field's edge or the image's depth runs through
// them.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <span>
#include <vector>

#include "nav/ray_image.h"
#include "nav/voxel_map.h"
#include "vision/polytope.h"

namespace headway::nav {

/// The space that is worth seeing: what the body needs, from the floor to the top of the head.
struct UsefulSpace {
  double lowest = -0.1, highest = 1.7;  ///< heights of voxel centres [m]
};

/// Keeps its memory between looks. The same map and pose give the same gain, whatever was asked before.
class ViewGain {
 public:
  /// `field` in the camera's optical frame, bounded and in front of the camera; rays are spaced for maps of
  /// this resolution [m]. Throws InputError when field or heights are unusable.
  ViewGain(const vision::Polytope& field, double resolution, const UsefulSpace& space = {});

  /// Number of unseen voxels of the useful space whose centre the field holds and whose ray meets no occupied
  /// voxel before it. Unseen voxels hide nothing: that is the most that the look can show.
  ///
  /// `looked`: poses of the camera, from about the same place, that were looked from already. What is still
  /// unseen in their fields is not to be had from here, and does not count; else a mirror or the open sky
  /// would be stared at for ever.
  std::size_t gain(const VoxelMap& map, const Eigen::Isometry3d& map_from_camera,
                   std::span<const Eigen::Isometry3d> looked = {});

  /// Of the last look. Depths are in voxels.
  const RayImage& rays() const { return rays_; }

 private:
  struct Look;
  struct BrickBox;
  BrickBox bricks_around(const VoxelMap& map, const Look& look) const;
  void end_rays_in(std::span<const Eigen::Isometry3d> looked, const VoxelMap& map,
                   const Eigen::Isometry3d& map_from_camera);
  void end_rays_at_obstacles(const VoxelMap& map, const Look& look, const BrickBox& box);
  std::size_t count(const VoxelMap& map, const Look& look, const BrickBox& box);
  std::size_t count_in(const VoxelMap& map, const Look& look, const Eigen::Vector3i& brick, int first_layer,
                       int end_layer);

  vision::Polytope field_;
  UsefulSpace space_;
  RayImage rays_;
  std::vector<Eigen::Vector4f> rows_;      ///< of the field, in voxels
  std::vector<Eigen::Vector4f> crossing_;  ///< those that run through the brick in work
};

}  // namespace headway::nav
