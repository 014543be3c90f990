// The oracle for polytopes: cddlib in exact rational arithmetic (its GMP build), told the same rows.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace headway::vision::test {

struct ExactPolytope {
  std::vector<Eigen::Vector4d> rows;     ///< those that no other makes redundant
  std::vector<Eigen::Vector3d> corners;  ///< rounded to double after the last step
  std::size_t directions = 0;            ///< extreme rays
};

/// Rows are taken as the rationals that their doubles are.
ExactPolytope exact_polytope(const std::vector<Eigen::Vector4d>& rows);

/// How many of the points are no convex combination of the others.
std::size_t exact_hull_vertices(const std::vector<Eigen::Vector3d>& points);

}  // namespace headway::vision::test
