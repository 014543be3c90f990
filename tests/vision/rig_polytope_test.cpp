#include "vision/rig_polytope.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "exact_polytope.h"
#include "hal/angle.h"
#include "hal/error.h"
#include "random_rig.h"
#include "vision/triangulation.h"

namespace headway::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using test::between;
using testing::HasSubstr;

RectifiedRig square_rig() {
  return {{480, 480, 240 / std::tan(16.5 * kDegree), 239.5, 239.5}, 0.144, 0, 0.8, 6};
}

RectifiedRig some_rectified_rig() {
  RectifiedRig rig;
  rig.camera = {320, 240, between(200, 600), between(140, 180), between(100, 140)};
  rig.baseline = between(0.03, 0.3);
  rig.disparity_offset = between(-30, 30);
  return rig;
}

StereoRig verged_rig(double degrees) {
  StereoRig rig;
  rig.name = "verged";
  rig.left = {640, 480, 1080, 1080, 319.5, 239.5};
  rig.right = rig.left;
  rig.right_from_left.linear() = Eigen::AngleAxisd(degrees * kDegree, Vector3d::UnitY()).toRotationMatrix();
  rig.right_from_left.translation() = -(rig.right_from_left.linear() * Vector3d(0.144, 0, 0));
  return rig;
}

template <class Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

struct Counts {
  std::size_t rows, corners, directions;
  bool operator==(const Counts&) const = default;
};
Counts counts(const Polytope& p) { return {p.rows.size(), p.corners.size(), p.directions.size()}; }

TEST(RigPolytope, OfARectifiedRigHas4Or5Or6HalfSpaces) {
  const RectifiedRig rig = square_rig();
  EXPECT_EQ(counts(rig_polytope(rig, {})), (Counts{4, 2, 4}));
  EXPECT_EQ(counts(rig_polytope(rig, {0.8})), (Counts{5, 4, 4}));
  EXPECT_EQ(counts(rig_polytope(rig, {0.8, 6})), (Counts{6, 8, 0}));
}

TEST(RigPolytope, OfAVergedRigHas8Or9Or10HalfSpaces) {
  // Toed in, so that the images cross some metres away.
  const StereoRig rig = verged_rig(3);
  EXPECT_EQ(counts(rig_polytope(rig, {})).rows, 8U);
  EXPECT_EQ(counts(rig_polytope(rig, {0.8})).rows, 9U);
  EXPECT_EQ(counts(rig_polytope(rig, {0.8, 6})), (Counts{10, 16, 0}));
}

RC_GTEST_PROP(RigPolytope, IsWhatExactArithmeticSays, ()) {
  const StereoRig rig = test::random_rig();
  const Vector3d z = depth_axis(rig);
  const auto left = left_projection(rig), right = right_projection(rig);
  std::vector<Vector4d> rows;
  for (const auto& p : {left, right}) {
    rows.push_back(half_space(p.row(0) + 0.5 * p.row(2)));
    rows.push_back(half_space((rig.left.width - 0.5) * p.row(2) - p.row(0)));
    rows.push_back(half_space(p.row(1) + 0.5 * p.row(2)));
    rows.push_back(half_space((rig.left.height - 0.5) * p.row(2) - p.row(1)));
  }
  rows.emplace_back(z.x(), z.y(), z.z(), -rig.nearest);
  rows.emplace_back(-z.x(), -z.y(), -z.z(), rig.farthest);
  const auto exact = test::exact_polytope(rows);
  const Polytope field = rig_polytope(rig, {rig.nearest, rig.farthest});
  RC_ASSERT(field.rows.size() == exact.rows.size());
  RC_ASSERT(field.corners.size() == exact.corners.size());
  for (const Vector3d& corner : exact.corners)
    RC_ASSERT(std::any_of(field.corners.begin(), field.corners.end(),
                          [&](const Vector3d& c) { return (c - corner).norm() < 1e-6; }));
  RC_ASSERT(is_minimal(field));
}

RC_GTEST_PROP(RigPolytope, HoldsEveryTriangulablePixelPair, ()) {
  const StereoRig rig = test::random_rig();
  const Polytope field = rig_polytope(rig, FieldLimits{});
  const auto left = left_projection(rig), right = right_projection(rig);
  const Vector2d in_left(*rc::gen::inRange(0, rig.left.width), *rc::gen::inRange(0, rig.left.height));
  // Along the left pixel's ray: the right pixel that the point falls into.
  for (double z = 0.1 * rig.nearest; z < 50 * rig.nearest; z *= 1.05) {
    const Vector3d p((in_left.x() - rig.left.cx) / rig.left.fx * z,
                     (in_left.y() - rig.left.cy) / rig.left.fy * z, z);
    const Vector3d q = right * p.homogeneous();
    const Vector2d in_right = q.hnormalized().array().round();
    if (q.z() <= 0 || in_right.x() < 0 || in_right.x() >= rig.right.width || in_right.y() < 0 ||
        in_right.y() >= rig.right.height)
      continue;
    if (const auto point = triangulate(left, right, in_left, in_right, 0.3))
      RC_ASSERT(field.contains(point->position));
  }
}

RC_GTEST_PROP(RigPolytope, HoldsExactlyThePointsThatBothImagesShow, ()) {
  const RectifiedRig rig = some_rectified_rig();
  const Polytope field = rig_polytope(rig, {0.8, 6});
  const PinholeCamera& c = rig.camera;
  const double z = between(0.5, 7);
  const Vector3d p(between(-0.8, 0.8) * z, between(-0.8, 0.8) * z, z);
  const double u = c.focal * p.x() / p.z() + c.cx, v = c.focal * p.y() / p.z() + c.cy;
  const double u_right = u - rig.disparity(p.z());
  const double inside = std::min({u + 0.5, c.width - 0.5 - u, u_right + 0.5, c.width - 0.5 - u_right, v + 0.5,
                                  c.height - 0.5 - v, p.z() - 0.8, 6 - p.z()});
  RC_PRE(std::abs(inside) > 1e-6);
  RC_ASSERT(field.contains(p) == (inside > 0));
}

RC_GTEST_PROP(RigPolytope, HasNoHalfSpaceThatIsNotTight, ()) {
  const StereoRig rig = test::random_rig();
  const Polytope field = rig_polytope(rig, {rig.nearest, rig.farthest});
  for (std::size_t left_out = 0; left_out < field.rows.size(); ++left_out) {
    const Vector4d row = field.rows[left_out];
    Vector3d middle = Vector3d::Zero();
    int count = 0;
    for (const Vector3d& corner : field.corners)
      if (std::abs(row.dot(corner.homogeneous())) < 1e-7) middle += corner, ++count;
    RC_ASSERT(count >= 3);
    middle /= count;
    RC_ASSERT(field.contains(middle, 1e-7));
    // Without the row, the set goes on beyond it.
    Polytope fewer = field;
    fewer.rows.erase(fewer.rows.begin() + static_cast<std::ptrdiff_t>(left_out));
    double room = 1e-3;
    for (const Vector4d& other : fewer.rows) room = std::min(room, other.dot(middle.homogeneous()));
    const Vector3d outside = middle - 0.5 * room * row.head<3>();
    RC_ASSERT(!field.contains(outside));
    RC_ASSERT(fewer.contains(outside));
  }
}

TEST(RigPolytope, LeavesOutTheColumnsThatAMatcherNeverFills) {
  const RectifiedRig rig = square_rig();
  // OpenCV's matcher without padding: no disparity for the first lowest + count columns.
  const DisparityRange range = disparity_range(rig);
  FieldLimits limits = depth_limits(rig, range);
  EXPECT_NEAR(limits.near, rig.camera.focal * rig.baseline / (range.lowest + range.count - 1), 1e-12);
  EXPECT_TRUE(std::isinf(limits.far));
  limits.far = 6;
  const Polytope whole = rig_polytope(rig, limits);
  limits.blind_columns = range.lowest + range.count;
  const Polytope seen = rig_polytope(rig, limits);
  EXPECT_EQ(counts(seen), (Counts{6, 8, 0}));
  for (const Vector3d& corner : seen.corners) EXPECT_TRUE(whole.contains(corner, 1e-9));
  const Vector3d in_blind = rig.camera.point(limits.blind_columns - 1, 240, 5);
  EXPECT_TRUE(whole.contains(in_blind));
  EXPECT_FALSE(seen.contains(in_blind));
  EXPECT_TRUE(seen.contains(rig.camera.point(limits.blind_columns, 240, 5)));
}

TEST(RigPolytope, EndsWhereTheLeastDisparityDoes) {
  RectifiedRig rig = square_rig();
  const FieldLimits limits = depth_limits(rig, {10, 64});
  EXPECT_NEAR(limits.far, rig.camera.focal * rig.baseline / 10, 1e-12);
}

TEST(RigPolytope, RefusesRigsThatSeeNothing) {
  RectifiedRig rig = square_rig();
  rig.baseline = 0;
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {}); }), HasSubstr("baseline 0 m"));
  rig.baseline = std::nan("");
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {}); }), HasSubstr("baseline"));
  rig = square_rig();
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {0.05, 0.1}); }), HasSubstr("begins at 0.243 m"));
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {2, 1}); }), HasSubstr("near < far"));
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {0.8, 6, 480}); }), HasSubstr("blind columns"));
  rig.disparity_offset = 500;  // the axes cross close by
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {7, 9}); }), HasSubstr("ends at 5.8"));
}

TEST(RigPolytope, RefusesDegenerateStereoRigs) {
  StereoRig rig = verged_rig(0);
  rig.right_from_left.translation().setZero();
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {}); }), HasSubstr("apart"));
  rig = verged_rig(0);
  rig.right_from_left.translation() *= 20;
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {}); }), HasSubstr("apart"));
  EXPECT_THAT(message_of([&] { rig_polytope(verged_rig(-40), {}); }), HasSubstr("apart"));
  EXPECT_THAT(message_of([&] { rig_polytope(verged_rig(180), {}); }), HasSubstr("apart"));
  // Two narrow cameras that stand askew pass each other by.
  rig = verged_rig(0);
  rig.right_from_left.linear() = Eigen::AngleAxisd(14 * kDegree, Vector3d::UnitX()).toRotationMatrix();
  rig.left.height = rig.right.height = 200;
  rig.left.cy = rig.right.cy = 99.5;
  EXPECT_THAT(message_of([&] { rig_polytope(rig, {}); }), HasSubstr("share 0 % of their images"));
}

}  // namespace
}  // namespace headway::vision
