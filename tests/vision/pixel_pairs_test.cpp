#include "vision/pixel_pairs.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "hal/error.h"
#include "vision/hull.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

// Two cameras 25 deg wide, each turned in by `inwards`.
StereoRig toed_in_rig(double inwards) {
  StereoRig rig;
  rig.name = "toed in";
  const double focal = 170 / std::tan(12.5 * kDegree);
  rig.left = {340, 480, focal, focal, 169.5, 239.5};
  rig.right = rig.left;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(inwards, Vector3d::UnitY()).toRotationMatrix();
  rig.right_from_left.linear() = turn * turn;
  rig.right_from_left.translation() = -(turn * Vector3d(0.144, 0, 0));
  return rig;
}

class PixelPairs : public testing::Test {
 protected:
  const StereoRig rig_ = toed_in_rig(2 * kDegree);
  const FieldLimits limits_{0.8, 6};
  const PixelPairField field_ = pixel_pair_field(rig_, limits_);
};

TEST_F(PixelPairs, TriangulateIntoTheRigsField) {
  const Polytope exact = rig_polytope(rig_, limits_);
  EXPECT_GT(field_.points.size(), 3000U);
  EXPECT_GE(field_.pairs, field_.points.size());
  for (const UncertainPoint& p : field_.points) EXPECT_TRUE(exact.contains(p.position, 1e-9));
}

TEST_F(PixelPairs, FillMostOfTheRigsField) {
  const Polytope exact = rig_polytope(rig_, limits_);
  for (const Vector3d& corner : exact.corners) {
    const Vector3d inside = corner + 0.35 * (Vector3d(0.07, 0, 3) - corner);
    EXPECT_TRUE(field_.minimal.contains(inside)) << inside.transpose();
  }
}

TEST_F(PixelPairs, LeaveAHundredHalfSpacesWhereThreeHundredWere) {
  // As the paper found: 250 became 132. Rounding to pixels makes them, so the numbers are those of a rig.
  EXPECT_GT(field_.hull.corners.size(), 150U);
  EXPECT_GT(field_.hull.rows.size(), 200U);
  EXPECT_LT(field_.minimal.rows.size(), 0.6 * static_cast<double>(field_.hull.rows.size()));
  EXPECT_GT(field_.minimal.rows.size(), 50U);
}

TEST_F(PixelPairs, AreHeldByTheMinimalForm) {
  EXPECT_TRUE(is_minimal(field_.hull, 1e-6));
  EXPECT_TRUE(is_minimal(field_.minimal, 1e-6));
  for (const UncertainPoint& p : field_.points) EXPECT_TRUE(field_.minimal.contains(p.position, 1e-9));
}

TEST_F(PixelPairs, OfARectifiedRigNeedNoMerging) {
  // Without rounding between rows, pixels lie on the planes of the field.
  const PixelPairField flat = pixel_pair_field(toed_in_rig(0), limits_);
  EXPECT_LE(flat.hull.rows.size(), 12U);
  EXPECT_EQ(flat.minimal.rows.size(), flat.hull.rows.size());
  EXPECT_EQ(flat.minimal.corners.size(), flat.hull.corners.size());
}

TEST_F(PixelPairs, RefuseDepthsThatNoPairReaches) {
  EXPECT_THROW(pixel_pair_field(rig_, {0.01, 0.02}), InputError);
  PixelPairConfig config;
  config.rows = 1;
  EXPECT_THROW(pixel_pair_field(rig_, limits_, config), InputError);
}

}  // namespace
}  // namespace headway::vision
