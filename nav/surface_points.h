// Where within its voxels a surface lies: for each voxel the mean and the spread of the points that were
// measured in it. The voxel map says what is occupied to within a voxel; localisation needs millimetres.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "nav/view_patches.h"
#include "nav/voxel_map.h"

namespace headway::nav {

/// A plane through the points around a voxel or in a block of voxels, in the map frame.
struct SurfacePlane {
  Eigen::Vector3d point;                           ///< the points' mean [m]
  Eigen::Vector3d normal;                          ///< of length 1
  double sigma = 0;                                ///< of the mean along the normal [m]
  Eigen::Matrix3d tilt = Eigen::Matrix3d::Zero();  ///< covariance of the normal [rad^2]
  double doubt = 0;    ///< variance that all the place has, by poses and by what patches err alike [m^2]
  bool sided = false;  ///< seen from where the normal points to; else from both sides, or it is not known
};

/// How well the pose of a view is known.
struct PoseVariance {
  double shift = 0;  ///< [m^2]
  double turn = 0;   ///< about the vertical [rad^2]
};

/// What is known of a voxel, as it is saved: sums over points, each with the weight 1/sigma^2 and seen from
/// the voxel's middle.
struct SurfaceVoxel {
  /// floor(coordinate / resolution) + 2^20 of x, y and z, in 21 bits each, x lowest; 0: none
  std::uint64_t key = 0;
  float weight = 0, count = 0;
  float doubt = 0;                ///< variance that all of it has by its first look [m^2]
  std::array<float, 3> first{};   ///< of w d [m]
  std::array<float, 6> second{};  ///< of w d d^T [m^2]: xx, xy, xz, yy, yz, zz
  std::array<float, 3> rays{};    ///< of w times the direction from the eye, in the map frame [1/m^2]

  friend bool operator==(const SurfaceVoxel&, const SurfaceVoxel&) = default;
};
static_assert(sizeof(SurfaceVoxel) == 72);

/// The first looks at a place decide, so that a map does not wander with what is measured by it: a voxel's
/// mean comes to rest when it is known to a millimetre, and only a look with far less doubt (from a pose that
/// is known better, or by a matcher from nearer) replaces it.
class SurfacePoints {
 public:
  /// `resolution`: of the map [m]. Keeps at most `most_voxels`, rounded up to a power of two,
  /// of 72 bytes each in a table with room for twice as many.
  explicit SurfacePoints(double resolution, std::size_t most_voxels = std::size_t{1} << 18);

  /// Adds the patches of a view that has been integrated into `map`. Points in voxels that the map is sure
  /// are empty are left out, and what was known there is forgotten.
  void add(std::span<const Patch> patches, const Eigen::Isometry3d& map_from_camera, const VoxelMap& map,
           const PoseVariance& pose = {});

  /// The plane of the surface at or beside a voxel of `map`. Nothing where the points of the 3x3x3 voxels
  /// around are too few or not flat, or where the map says that their mean is not occupied (any more), or
  /// that both sides of it are empty: of a thing so thin, noise mixes the points of both faces.
  std::optional<SurfacePlane> plane(const VoxelMap::Index& voxel, const VoxelMap& map) const;

  static constexpr int kBlock = 4;  ///< voxels along an edge
  /// Which block a voxel lies in, by its absolute index (VoxelMap::first_key).
  static VoxelMap::Index block_of(const VoxelMap::Index& absolute) {
    static_assert(kBlock == 1 << 2);
    return {absolute.x() >> 2, absolute.y() >> 2, absolute.z() >> 2};
  }
  /// The plane of all points in a block. Its normal is known far better than those of the voxels in it, where
  /// noise is not small beside what they span. Nothing where they are too few or not flat, or where the map
  /// says that nothing is left beside their mean, or that both sides of it are empty.
  std::optional<SurfacePlane> block_plane(const VoxelMap::Index& block, const VoxelMap& map) const;

  std::size_t voxels() const { return used_; }  ///< known
  std::size_t bytes() const { return cells_.size() * sizeof(Cell); }

  double resolution() const { return resolution_; }  ///< [m]
  /// All that is known, by rising key.
  std::vector<SurfaceVoxel> saved() const;
  /// Takes in what was saved and is not known here. False, and nothing changes, when it is no such thing, or
  /// there is no room.
  bool restore(const SurfaceVoxel& voxel);

 private:
  struct Cell : SurfaceVoxel {
    void forget() { static_cast<SurfaceVoxel&>(*this) = {.key = key}; }
    void add(const Eigen::Vector3f& d, float w, const Eigen::Vector3f& ray);
  };

  struct Sums;
  struct Box {
    VoxelMap::Index first, size;  ///< absolute; voxels along each axis
  };
  Sums sums_of(const Box& box) const;
  Box uncut(const SurfacePlane& plane, double sigma, const Box& block, const VoxelMap& map) const;
  bool between_empty(const SurfacePlane& plane, const VoxelMap& map) const;
  bool admit(const VoxelMap::Index& absolute, float doubt);
  static std::uint64_t key_of(const VoxelMap::Index& absolute);
  std::size_t place(std::uint64_t key) const;
  const Cell* find(std::uint64_t key) const {
    const Cell& cell = cells_[place(key)];
    return cell.key == key ? &cell : nullptr;
  }
  Cell* find(std::uint64_t key) {
    Cell& cell = cells_[place(key)];
    return cell.key == key ? &cell : nullptr;
  }
  Cell* make(std::uint64_t key, const VoxelMap& map);
  void rebuild(std::size_t size, const VoxelMap* keep_known_to);

  double resolution_;
  std::size_t most_, used_ = 0;
  std::vector<Cell> cells_;  ///< open addressing, a power of two, at most half full
};

}  // namespace headway::nav
