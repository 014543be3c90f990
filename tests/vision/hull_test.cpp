#include "vision/hull.h"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "exact_polytope.h"
#include "hal/error.h"
#include "random_rig.h"
#include "vision/rig_polytope.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using test::between;

// Some on a sphere, so that they are vertices, and some within.
std::vector<Vector3d> some_points() {
  std::vector<Vector3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int count = *rc::gen::inRange(0, 40);
  for (int i = 0; i < count; ++i) {
    const Vector3d v(between(-1, 1), between(-1, 1), between(-1, 1));
    points.push_back(i % 2 == 0 && v.norm() > 0.1 ? Vector3d(2 * v.normalized()) : v);
  }
  return points;
}

RC_GTEST_PROP(Hull, HoldsItsPointsAndIsMinimal, ()) {
  const auto points = some_points();
  const Polytope hull = hull_polytope(points);
  for (const Vector3d& p : points) RC_ASSERT(hull.contains(p, 1e-12));
  RC_ASSERT(is_minimal(hull, 1e-9));
}

RC_GTEST_PROP(Hull, HasTheVerticesThatExactArithmeticFinds, ()) {
  const auto points = some_points();
  std::set<std::array<double, 3>> once;
  for (const Vector3d& p : points) once.insert({p.x(), p.y(), p.z()});
  std::vector<Vector3d> distinct;
  for (const auto& p : once) distinct.emplace_back(p[0], p[1], p[2]);
  RC_ASSERT(hull_polytope(points).corners.size() == test::exact_hull_vertices(distinct));
}

RC_GTEST_PROP(Hull, MeshIsClosedAndFacesOutwards, ()) {
  const auto points = some_points();
  const TriangleMesh mesh = hull_mesh(points);
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : mesh.corners) middle += p / static_cast<double>(mesh.corners.size());
  // Each edge belongs to two triangles that run along it in opposite ways.
  std::map<std::pair<std::size_t, std::size_t>, int> half_edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++half_edges[{t[i], t[(i + 1) % 3]}];
    const Vector3d &a = mesh.corners[t[0]], &b = mesh.corners[t[1]], &c = mesh.corners[t[2]];
    RC_ASSERT((b - a).cross(c - a).dot(a - middle) >= 0);
  }
  for (const auto& [edge, count] : half_edges) {
    RC_ASSERT(count == 1);
    RC_ASSERT(half_edges.count({edge.second, edge.first}) == 1U);
  }
  RC_ASSERT(mesh.corners.size() - half_edges.size() / 2 + mesh.triangles.size() == 2U);
}

RC_GTEST_PROP(Hull, DualityLeavesOutTheRowsThatExactArithmeticLeavesOut, ()) {
  std::vector<Vector4d> rows{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, half_space({-1, -1, -1, 1})};
  const int count = *rc::gen::inRange(0, 30);
  for (int i = 0; i < count; ++i) {
    const Vector3d v(between(-1, 1), between(-1, 1), between(-1, 1));
    if (v.norm() > 0.1) rows.push_back(half_space({v.x(), v.y(), v.z(), v.norm() * between(0.2, 2)}));
  }
  const Polytope minimal = minimal_polytope(rows, Vector3d::Zero());
  const auto exact = test::exact_polytope(rows);
  RC_ASSERT(minimal.rows.size() == exact.rows.size());
  RC_ASSERT(minimal.corners.size() == exact.corners.size());
  for (const Vector3d& corner : exact.corners)
    RC_ASSERT(std::any_of(minimal.corners.begin(), minimal.corners.end(), [&](const Vector3d& c) {
      return (c - corner).norm() < 1e-8 * (1 + corner.norm());
    }));
}

RC_GTEST_PROP(Hull, OfAFieldsCornersIsTheField, ()) {
  const StereoRig rig = test::random_rig();
  const Polytope field = rig_polytope(rig, {rig.nearest, rig.farthest});
  const Polytope hull = hull_polytope(field.corners);
  RC_ASSERT(hull.corners.size() == field.corners.size());
  for (const Vector3d& corner : field.corners) RC_ASSERT(hull.contains(corner, 1e-9));
  for (const Vector4d& row : field.rows)
    RC_ASSERT(std::any_of(hull.rows.begin(), hull.rows.end(), [&](const Vector4d& r) {
      return (r - row).norm() < 1e-5 * (1 + std::abs(row.w()));
    }));
}

TEST(Hull, MergesHalfSpacesThatAreNearlyOne) {
  const Vector4d row(0, 0, 1, 1);
  const double angle = 0.003;
  const Vector4d turned = half_space({0, 0.002, 1, 1}), turned_far = half_space({0, 0.004, 1, 1});
  EXPECT_EQ(merged({row, turned}, angle, 0.01).size(), 1U);
  EXPECT_EQ(merged({row, turned_far}, angle, 0.01).size(), 2U);
  EXPECT_EQ(merged({row, {0, 0, 1, 1.02}}, angle, 0.01).size(), 2U);
  EXPECT_EQ(merged({row, {0, 0, -1, 1}}, angle, 0.01).size(), 2U);
}

TEST(Hull, RefusesPointsThatSpanNoVolume) {
  EXPECT_THROW(hull_polytope({}), InputError);
  EXPECT_THROW(hull_polytope({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), InputError);
  testing::internal::CaptureStderr();
  EXPECT_THROW(hull_polytope({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.2, 0}}), InputError);
  EXPECT_THROW(hull_mesh({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), InputError);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Hull, RefusesHalfSpacesThatAreNoPolytope) {
  const std::vector<Vector4d> endless{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {-1, 0, 0, 1}};
  EXPECT_THROW(minimal_polytope(endless, Vector3d::Zero()), InputError);
  EXPECT_THROW(minimal_polytope(endless, Vector3d(2, 0, 0)), InputError);
}

}  // namespace
}  // namespace headway::vision
