#include "vision/polytope.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace headway::vision {

namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using Rows = std::vector<Vector4d>;

// Rows closer than this are one: at 1 m their planes part by a tenth of a micrometre. What is left meets at
// angles above it, so the rounding of a vertex (1e-16 over that angle) stays below the second tolerance.
constexpr double kSameRow = 1e-7;
// How far off a plane a vertex may lie and still count as on it, as a share of its distance (or of a metre).
constexpr double kTouch = 1e-8;
// A vertex farther away than 10 000 km is a direction.
constexpr double kEndless = 1e-7;

Rows without_doubles(const Rows& rows) {
  Rows once;
  for (const Vector4d& row : rows)
    if (std::none_of(once.begin(), once.end(),
                     [&](const Vector4d& r) { return (r - row).norm() < kSameRow * std::hypot(1, r.w()); }))
      once.push_back(row);
  return once;
}

// The homogeneous point on three planes: orthogonal to all three rows. Its length tells how well they meet.
Vector4d meeting(const Vector4d& a, const Vector4d& b, const Vector4d& c) {
  Vector4d point;
  for (int i = 0; i < 4; ++i) {
    Eigen::Matrix3d minor;
    for (int j = 0, k = 0; j < 4; ++j)
      if (j != i) minor.col(k++) << a[j], b[j], c[j];
    point[i] = (i % 2 == 0 ? 1 : -1) * minor.determinant();
  }
  return point;
}

bool inside(const Rows& rows, const Vector4d& point) {
  return std::all_of(rows.begin(), rows.end(),
                     [&](const Vector4d& r) { return r.dot(point) >= -kTouch * std::hypot(1, r.w()); });
}

// Unit homogeneous vertices, w >= 0; w = 0 is a direction. `rows` holds the plane at infinity as its last.
std::vector<Vector4d> vertices_of(const Rows& rows) {
  std::vector<Vector4d> found;
  const auto add = [&](Vector4d p) {
    if (!inside(rows, p)) return;
    if (p.w() < kEndless) p.w() = 0, p.normalize();
    if (std::none_of(found.begin(), found.end(),
                     [&](const Vector4d& q) { return (p - q).norm() < 10 * kTouch; }))
      found.push_back(p);
  };
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = i + 1; j < rows.size(); ++j)
      for (std::size_t k = j + 1; k < rows.size(); ++k) {
        const Vector4d p = meeting(rows[i], rows[j], rows[k]);
        const double length = p.norm();
        if (length < kTouch * kSameRow) continue;  // they share a line
        add(p / length);
        add(-p / length);
      }
  return found;
}

// True when the vertices on this plane span it: then the row cannot be left out.
bool carries_a_face(const Vector4d& row, const std::vector<Vector4d>& vertices) {
  Eigen::Matrix4Xd on(4, 0);
  for (const Vector4d& p : vertices) {
    if (std::abs(row.dot(p)) > 10 * kTouch * std::hypot(1, row.w())) continue;
    on.conservativeResize(4, on.cols() + 1);
    on.rightCols<1>() = p;
  }
  if (on.cols() < 3) return false;
  const Eigen::JacobiSVD<Eigen::Matrix4Xd> svd(on);
  return svd.singularValues()(2) > 10 * kTouch;
}

bool spans_a_volume(const std::vector<Vector4d>& vertices) {
  if (vertices.size() < 4) return false;
  Eigen::Matrix4Xd all(4, static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i) all.col(static_cast<Eigen::Index>(i)) = vertices[i];
  return Eigen::JacobiSVD<Eigen::Matrix4Xd>(all).singularValues()(3) > 10 * kTouch;
}

bool touches(const Vector4d& row, const Vector3d& point, double tolerance) {
  return std::abs(row.dot(point.homogeneous())) < tolerance;
}

}  // namespace

std::optional<Polytope> minimal_polytope(const std::vector<Vector4d>& rows) {
  const Vector4d infinity = Vector4d::UnitW();
  Rows with_infinity = without_doubles(rows);
  with_infinity.push_back(infinity);
  const std::vector<Vector4d> vertices = vertices_of(with_infinity);
  if (!spans_a_volume(vertices)) return std::nullopt;
  with_infinity.pop_back();
  Polytope out;
  for (const Vector4d& row : with_infinity)
    if (carries_a_face(row, vertices)) out.rows.push_back(row);
  for (const Vector4d& p : vertices)
    if (p.w() > 0)
      out.corners.push_back(p.hnormalized());
    else
      out.directions.push_back(p.head<3>());
  return out;
}

Polytope moved(const Polytope& polytope, const Eigen::Isometry3d& to_from_polytope) {
  Polytope out;
  for (const Vector4d& row : polytope.rows) out.rows.push_back(moved(row, to_from_polytope));
  for (const Vector3d& corner : polytope.corners) out.corners.push_back(to_from_polytope * corner);
  for (const Vector3d& along : polytope.directions)
    out.directions.push_back(to_from_polytope.linear() * along);
  return out;
}

std::vector<std::pair<std::size_t, std::size_t>> edges(const Polytope& polytope) {
  constexpr double kOn = 1e-6;  // [m]
  std::vector<std::pair<std::size_t, std::size_t>> found;
  for (std::size_t i = 0; i < polytope.corners.size(); ++i)
    for (std::size_t j = i + 1; j < polytope.corners.size(); ++j) {
      const auto common = std::count_if(polytope.rows.begin(), polytope.rows.end(), [&](const Vector4d& row) {
        return touches(row, polytope.corners[i], kOn) && touches(row, polytope.corners[j], kOn);
      });
      if (common >= 2) found.emplace_back(i, j);
    }
  return found;
}

bool is_minimal(const Polytope& polytope, double tolerance) {
  const auto is_corner = [&](const Vector3d& corner) {
    return polytope.contains(corner, tolerance) &&
           std::count_if(polytope.rows.begin(), polytope.rows.end(),
                         [&](const Vector4d& row) { return touches(row, corner, tolerance); }) >= 3;
  };
  const auto matters = [&](const Vector4d& row) {
    Vector3d middle = Vector3d::Zero();
    int count = 0;
    for (const Vector3d& corner : polytope.corners)
      if (touches(row, corner, tolerance)) middle += corner, ++count;
    if (count < 3) return false;
    middle /= count;
    // In the middle of its face only this row's distance is nil.
    return std::all_of(polytope.rows.begin(), polytope.rows.end(), [&](const Vector4d& other) {
      return &other == &row || other.dot(middle.homogeneous()) > 0;
    });
  };
  return polytope.corners.size() >= 4 && polytope.directions.empty() &&
         std::all_of(polytope.corners.begin(), polytope.corners.end(), is_corner) &&
         std::all_of(polytope.rows.begin(), polytope.rows.end(), matters);
}

}  // namespace headway::vision
