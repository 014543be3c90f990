#include "vision/polytope.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "exact_polytope.h"
#include "random_rig.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using test::between;

Vector3d some_direction() {
  Vector3d v(between(-1, 1), between(-1, 1), between(-1, 1));
  return v.norm() > 0.1 ? v.normalized() : Vector3d::UnitX();
}

// Planes around the origin, some of them of no effect; now and then too few to close the shape. The first
// three see to it that there is a corner.
std::vector<Vector4d> some_rows() {
  std::vector<Vector4d> rows{
      {1, 0, 0, between(0.1, 3)}, {0, 1, 0, between(0.1, 3)}, {0, 0, 1, between(0.1, 3)}};
  const int count = *rc::gen::inRange(0, 12);
  for (int i = 0; i < count; ++i) {
    const Vector3d normal = some_direction();
    rows.emplace_back(normal.x(), normal.y(), normal.z(), between(0.1, 3));
  }
  return rows;
}

std::vector<Vector4d> cube() {
  std::vector<Vector4d> rows;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) rows.emplace_back(sign * Vector3d::Unit(axis).homogeneous());
  for (Vector4d& row : rows) row.w() = 1;
  return rows;
}

RC_GTEST_PROP(Polytope, KeepsTheRowsAndCornersThatExactArithmeticKeeps, ()) {
  const auto rows = some_rows();
  const auto polytope = minimal_polytope(rows);
  RC_ASSERT(polytope.has_value());
  const auto exact = test::exact_polytope(rows);
  RC_ASSERT(polytope->rows.size() == exact.rows.size());
  for (const Vector4d& row : exact.rows)
    RC_ASSERT(std::any_of(polytope->rows.begin(), polytope->rows.end(),
                          [&](const Vector4d& r) { return (r - row).norm() < 1e-12; }));
  RC_ASSERT(polytope->corners.size() == exact.corners.size());
  for (const Vector3d& corner : exact.corners)
    RC_ASSERT(std::any_of(polytope->corners.begin(), polytope->corners.end(),
                          [&](const Vector3d& c) { return (c - corner).norm() < 1e-7 * corner.norm(); }));
  RC_ASSERT(polytope->directions.size() == exact.directions);
}

RC_GTEST_PROP(Polytope, MovesWithItsFrame, ()) {
  const auto polytope = minimal_polytope(some_rows());
  RC_ASSERT(polytope.has_value());
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  t.linear() = Eigen::AngleAxisd(between(-3, 3), some_direction()).toRotationMatrix();
  t.translation() = 2 * some_direction();
  const Polytope there = moved(*polytope, t);
  const Vector3d p = 3 * some_direction();
  for (std::size_t i = 0; i < there.rows.size(); ++i)
    RC_ASSERT(std::abs(there.rows[i].dot((t * p).homogeneous()) - polytope->rows[i].dot(p.homogeneous())) <
              1e-12);
  for (const Vector3d& corner : there.corners) RC_ASSERT(there.contains(corner, 1e-6 * corner.norm() + 1e-6));
}

TEST(Polytope, OfACubeHasSixRowsEightCornersTwelveEdges) {
  auto rows = cube();
  rows.push_back(half_space({1, 1, 1, 3}));  // touches a corner
  rows.push_back(half_space({1, 1, 0, 2}));  // touches an edge
  rows.push_back(rows.front());              // twice
  rows.emplace_back(0, 0, 1, 5);             // beyond
  const auto polytope = minimal_polytope(rows);
  ASSERT_TRUE(polytope);
  EXPECT_EQ(polytope->rows.size(), 6U);
  EXPECT_EQ(polytope->corners.size(), 8U);
  EXPECT_EQ(edges(*polytope).size(), 12U);
  EXPECT_TRUE(polytope->directions.empty());
  EXPECT_TRUE(is_minimal(*polytope));
  EXPECT_TRUE(polytope->contains({1, 1, 1}));
  EXPECT_FALSE(polytope->contains({1.01, 0, 0}));
  EXPECT_TRUE(polytope->contains({1.01, 0, 0}, 0.02));
}

TEST(Polytope, TellsWhereItNeverEnds) {
  auto rows = cube();
  rows.erase(rows.begin());  // -x <= 1 stays; x may grow
  const auto polytope = minimal_polytope(rows);
  ASSERT_TRUE(polytope);
  EXPECT_EQ(polytope->rows.size(), 5U);
  EXPECT_EQ(polytope->corners.size(), 4U);
  ASSERT_EQ(polytope->directions.size(), 1U);
  EXPECT_NEAR(std::abs(polytope->directions[0].x()), 1, 1e-12);
}

TEST(Polytope, IsNothingWithoutVolume) {
  auto rows = cube();
  rows.emplace_back(1, 0, 0, -2);
  EXPECT_FALSE(minimal_polytope(rows)) << "nothing at all";
  rows.back().w() = -1;
  EXPECT_FALSE(minimal_polytope(rows)) << "only a face";
}

TEST(Polytope, IsNotMinimalWithARowTooManyOrACornerThatIsNone) {
  const auto polytope = minimal_polytope(cube());
  Polytope more = *polytope;
  more.rows.emplace_back(0, 0, 1, 1.5);
  EXPECT_FALSE(is_minimal(more));
  more.rows.back() = half_space({1, 1, 1, 3});
  EXPECT_FALSE(is_minimal(more));
  more.rows.back() = more.rows.front();
  EXPECT_FALSE(is_minimal(more));
  Polytope fewer = *polytope;
  fewer.rows.pop_back();
  EXPECT_FALSE(is_minimal(fewer));
  Polytope blunt = *polytope;
  blunt.corners.emplace_back(1, 1, 0);
  EXPECT_FALSE(is_minimal(blunt));
  blunt.corners.back() = {1, 1, 1.1};
  EXPECT_FALSE(is_minimal(blunt));
}

}  // namespace
}  // namespace headway::vision
