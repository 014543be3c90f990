// Convex hulls of points, by qhull: as half-spaces, as a polytope without redundant rows, as a closed mesh to
// show.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "vision/polytope.h"

namespace headway::vision {

/// Triangles over corners, counter-clockwise seen from outside (normals point outwards).
struct TriangleMesh {
  std::vector<Eigen::Vector3d> corners;  ///< [m]
  std::vector<std::array<std::size_t, 3>> triangles;
};

/// The hull as a polytope: one row for each facet (coplanar triangles are one), the vertices as corners.
/// Exact up to qhull's rounding of some 1e-15 of the coordinates; never joggled (qhull's QJ turns 8 vertices
/// into dozens). Throws InputError for points that span no volume.
Polytope hull_polytope(const std::vector<Eigen::Vector3d>& points);

/// The hull's surface: watertight, Euler characteristic 2. Throws like `hull_polytope`.
TriangleMesh hull_mesh(const std::vector<Eigen::Vector3d>& points);

/// Of several half-spaces of which one stands within `angle` [rad] and `offset` [m] of another, keeps the
/// first. The set can only grow by that.
std::vector<Eigen::Vector4d> merged(const std::vector<Eigen::Vector4d>& rows, double angle, double offset);

/// Leaves out redundant rows, of which there may be hundreds, and finds the corners: by duality the rows that
/// matter are the vertices of the hull of a_i / (a_i . inside), and its facets are the corners. `inside` must
/// lie off all planes. Throws InputError when it does not, or when the rows leave the set endless.
Polytope minimal_polytope(const std::vector<Eigen::Vector4d>& rows, const Eigen::Vector3d& inside);

}  // namespace headway::vision
