// Convex pieces of space as half-spaces A x >= 0, above all the field of a rig. Plain values, no OpenCV.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace headway::vision {

/// The polytope A x >= 0 (paper, section II) with x = (x, y, z, 1) in metres. Each row of A is scaled so that
/// A x is the distance to its plane [m], positive inside. No row is redundant.
struct Polytope {
  std::vector<Eigen::Vector4d> rows;
  std::vector<Eigen::Vector3d> corners;  ///< the vertices [m]
  std::vector<Eigen::Vector3d>
      directions;  ///< unit vectors along which it never ends; none when it is bounded

  /// Whether the point lies inside, on a plane, or at most `outside` [m] beyond one.
  bool contains(const Eigen::Vector3d& point, double outside = 0) const {
    for (const Eigen::Vector4d& row : rows)
      if (row.dot(point.homogeneous()) < -outside) return false;
    return true;
  }
};

/// A row of A from any multiple of it.
inline Eigen::Vector4d half_space(const Eigen::Vector4d& row) { return row / row.head<3>().norm(); }

/// The same polytope with only the rows that matter, and its corners and directions. For a few dozen rows:
/// all triples of planes are tried, in homogeneous coordinates, so that far and endless shapes are as exact
/// as near ones. Nothing when no volume is left.
std::optional<Polytope> minimal_polytope(const std::vector<Eigen::Vector4d>& rows);

/// The polytope in another frame.
Polytope moved(const Polytope& polytope, const Eigen::Isometry3d& to_from_polytope);

/// Corners that an edge joins: those on two common planes. Pairs of indices, the lower first.
std::vector<std::pair<std::size_t, std::size_t>> edges(const Polytope& polytope);

/// Looks each corner and each row over: every corner lies on three planes and, within `tolerance` [m],
/// outside none; every row has a point just beyond its face that all others let pass. For bounded polytopes.
bool is_minimal(const Polytope& polytope, double tolerance = 1e-7);

}  // namespace headway::vision
