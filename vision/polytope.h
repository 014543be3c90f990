// Convex pieces of space as half-spaces A x >= 0, above all the field of a rig. Plain values, no OpenCV.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

namespace headway::vision {

/// On which side of a half-space's plane a point lies: A's row times (x, y, z, 1), positive inside; the
/// distance [m] where the row is scaled so. `contains` in all its forms and the ends of visible rows of
/// voxels are this expression, so that they agree even on points that lie on a plane.
inline double side(const Eigen::Vector4d& row, double x, double y, double z) {
  return ((row[0] * x + row[1] * y) + row[2] * z) + row[3];
}

/// True where A x >= -outside for each row of A, x = (x, y, z, 1). Without rows all of space is inside; a
/// point with a NaN is outside of any row.
inline bool contains(std::span<const Eigen::Vector4d> rows, double x, double y, double z,
                     double outside = 0) {
  for (const Eigen::Vector4d& row : rows)
    if (!(side(row, x, y, z) >= -outside)) return false;
  return true;
}

/// The polytope A x >= 0 (paper, section II) with x = (x, y, z, 1) in metres. Each row of A is scaled so that
/// A x is the distance to its plane [m], positive inside. No row is redundant.
struct Polytope {
  std::vector<Eigen::Vector4d> rows;
  std::vector<Eigen::Vector3d> corners;  ///< the vertices [m]
  std::vector<Eigen::Vector3d>
      directions;  ///< unit vectors along which it never ends; none when it is bounded

  /// Whether the point lies inside, on a plane, or at most `outside` [m] beyond one.
  bool contains(const Eigen::Vector3d& point, double outside = 0) const {
    return vision::contains(rows, point.x(), point.y(), point.z(), outside);
  }
};

/// A row of A from any multiple of it.
inline Eigen::Vector4d half_space(const Eigen::Vector4d& row) { return row / row.head<3>().norm(); }

/// The same polytope with only the rows that matter, and its corners and directions. For a few dozen rows:
/// all triples of planes are tried, in homogeneous coordinates, so that far and endless shapes are as exact
/// as near ones. Nothing when no volume is left.
std::optional<Polytope> minimal_polytope(const std::vector<Eigen::Vector4d>& rows);

/// The half-space in another frame: side(moved, to_from_row * p) = side(row, p).
inline Eigen::Vector4d moved(const Eigen::Vector4d& row, const Eigen::Isometry3d& to_from_row) {
  return to_from_row.inverse().matrix().transpose() * row;
}

/// The polytope in another frame.
Polytope moved(const Polytope& polytope, const Eigen::Isometry3d& to_from_polytope);

/// Corners that an edge joins: those on two common planes. Pairs of indices, the lower first.
std::vector<std::pair<std::size_t, std::size_t>> edges(const Polytope& polytope);

/// Looks each corner and each row over: every corner lies on three planes and, within `tolerance` [m],
/// outside none; every row has a point just beyond its face that all others let pass. For bounded polytopes.
bool is_minimal(const Polytope& polytope, double tolerance = 1e-7);

}  // namespace headway::vision
