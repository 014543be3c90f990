#include "vision/pixel_pairs.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "hal/angle.h"
#include "hal/error.h"
#include "vision/hull.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;

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

// Lenses that move the corners of their images by a dozen pixels.
TEST_F(PixelPairs, AreWholePixelsOfImagesThatTheLensDistorts) {
  StereoRig barrel = rig_;
  barrel.left.k1 = barrel.right.k1 = -0.25;
  const PixelPairField field = pixel_pair_field(barrel, limits_);
  EXPECT_GT(field.points.size(), 3000U);
  const auto off_the_lattice = [](double at, int size) {  // of 17 whole pixels from the first to the last
    const double i = std::clamp(std::round(at * 16 / (size - 1)), 0.0, 16.0);
    return std::abs(at - std::round((size - 1) * i / 16));
  };
  for (const UncertainPoint& p : field.points) {
    const Eigen::Vector2d left = barrel.left.project(p.position),
                          right = barrel.right.project(barrel.right_from_left * p.position);
    EXPECT_LT(off_the_lattice(left.x(), barrel.left.width), 1);
    EXPECT_LT(off_the_lattice(left.y(), barrel.left.height), 1);
    EXPECT_TRUE(right.x() > -1 && right.x() < barrel.right.width) << right.transpose();
    EXPECT_TRUE(right.y() > -1 && right.y() < barrel.right.height) << right.transpose();
  }
}

TEST_F(PixelPairs, RefuseDepthsThatNoPairReaches) {
  EXPECT_THROW(pixel_pair_field(rig_, {0.01, 0.02}), InputError);
  PixelPairConfig config;
  config.rows = 1;
  EXPECT_THROW(pixel_pair_field(rig_, limits_, config), InputError);
}

}  // namespace
}  // namespace headway::vision
