// Which voxels a rig can see: row by row of a grid, one interval per row in place of a test per voxel.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "vision/polytope.h"

namespace headway::vision {

/// `contains` (polytope.h) of many points in planes, as DensePoints has them: inside[i] is 1 or 0. All spans
/// are of one size.
void contains(std::span<const Eigen::Vector4d> rows, std::span<const float> x, std::span<const float> y,
              std::span<const float> z, std::span<std::uint8_t> inside);

/// Cubic voxels, x running fastest.
struct VoxelGrid {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< the grid's lowest corner in the map frame [m]
  double resolution = 0.05;                          ///< edge of a voxel [m]
  int nx = 0, ny = 0, nz = 0;

  /// Centre of the i-th voxel along an axis (0 x, 1 y, 2 z) [m].
  double centre(int axis, int i) const { return origin[axis] + (i + 0.5) * resolution; }
};

/// The voxels [first, last) of a row. An empty row is [0, 0).
struct RowSpan {
  std::int32_t first = 0, last = 0;
  bool operator==(const RowSpan&) const = default;
};

/// Where along the rows a half-space begins or ends: at + along_y j + along_z k, in voxels. Of one along the
/// rows themselves, which takes all of a row or nothing, its `side` instead.
struct RowBound {
  double at, along_y, along_z;
  double doubt;  ///< how far rounding may have moved it
  double here;   ///< at + along_z k of the layer in hand
};

/// The voxels of a grid whose centres lie in a convex polytope. Each half-space bounds a row of voxels at one
/// end or not at all, so a row costs as much as a few points. Keeps its memory from call to call.
class VisibleRows {
 public:
  /// `rows`: the polytope A x >= 0 in the camera's frame. Gives a span for each row of voxels, that of (y =
  /// j, z = k) at [k ny + j]; valid until the next call. It holds exactly the voxels i for which
  /// contains(in_map(), centre(0, i), centre(1, j), centre(2, k)) is true.
  std::span<const RowSpan> find(std::span<const Eigen::Vector4d> rows, const VoxelGrid& grid,
                                const Eigen::Isometry3d& map_from_camera);

  /// The half-spaces of the last call in the map frame.
  std::span<const Eigen::Vector4d> in_map() const { return in_map_; }

 private:
  void add_bound(const Eigen::Vector4d& row, const VoxelGrid& grid);

  std::vector<Eigen::Vector4d> in_map_;
  std::vector<RowBound> lower_, upper_, whole_;
  std::vector<RowSpan> spans_;
};

}  // namespace headway::vision
