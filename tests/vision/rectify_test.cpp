#include "vision/rectify.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "random_rig.h"
#include "scene.h"

namespace headway::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::between;
using test::random_rig;

StereoRig ideal_rig() {
  StereoRig rig;
  rig.left = {64, 48, 80, 80, 31.5, 23.5};
  rig.right = rig.left;
  rig.right_from_left.translation().x() = -0.1;
  return rig;
}

RC_GTEST_PROP(Rectifier, PutsPartnersInOneRowAtTheDisparityOfTheirDepth, ()) {
  const StereoRig rig = random_rig();
  const Rectifier rectifier(rig);
  const double u = between(0, rig.left.width - 1), v = between(0, rig.left.height - 1), z = between(0.5, 20);
  const Vector3d in_left = z * test::ray(rig.left, u, v);
  const Vector3d in_right = rig.right_from_left * in_left;

  const Vector2d left = rectifier.rectified_left(rig.left.project(in_left));
  const Vector2d right = rectifier.rectified_right(rig.right.project(in_right));
  const Vector3d rectified = rectifier.rectified_from_left() * in_left;
  RC_ASSERT(std::abs(left.y() - right.y()) < 1e-5);
  RC_ASSERT(std::abs(left.x() - right.x() - rectifier.rig().disparity(rectified.z())) < 1e-5);
  // The camera it reports is the one that sees the point there.
  RC_ASSERT((rectifier.camera().point(left.x(), left.y(), rectified.z()) - rectified).norm() < 1e-5 * z);
}

RC_GTEST_PROP(Rectifier, KeepsTheBaselineAndShowsNoBorders, ()) {
  const StereoRig rig = random_rig();
  const Rectifier rectifier(rig);
  RC_ASSERT(std::abs(rectifier.baseline() - rig.baseline()) < 1e-12);
  const PinholeCamera& c = rectifier.camera();
  // Every corner of the rectified image looks at something that the raw left image shows, to within a pixel.
  for (const double u : {0.0, c.width - 1.0})
    for (const double v : {0.0, c.height - 1.0}) {
      const Vector2d raw = rig.left.project(rectifier.rectified_from_left().inverse() * c.point(u, v, 1));
      RC_ASSERT(raw.x() > -1.5 && raw.x() < rig.left.width + 0.5);
      RC_ASSERT(raw.y() > -1.5 && raw.y() < rig.left.height + 0.5);
    }
}

RC_GTEST_PROP(Rectifier, LooksUpTheGreyValuesOfTheRawImage, ()) {
  const StereoRig rig = random_rig();
  const Rectifier rectifier(rig);
  // A ramp survives interpolation, so each grey value tells the raw column it came from.
  const auto ramp = test::image(rig.left.width, rig.left.height,
                                [](int u, int) { return static_cast<std::uint8_t>(2 * u); });
  hal::GrayImage left, right;
  rectifier.rectify(ramp, ramp, left, right);
  const PinholeCamera& c = rectifier.camera();
  const int u = *rc::gen::inRange(2, c.width - 2), v = *rc::gen::inRange(2, c.height - 2);
  const Vector2d raw = rig.left.project(rectifier.rectified_from_left().inverse() * c.point(u, v, 1));
  const double found = left.pixels[static_cast<std::size_t>(v * c.width + u)];
  RC_ASSERT(std::abs(found - 2 * raw.x()) < 1);
}

TEST(Rectifier, PassesRectifiedPairsUntouched) {
  StereoRig rig = ideal_rig();
  rig.right.cx += 5;  // as in Middlebury's pairs: disparity is counted from other columns
  const Rectifier rectifier(rig);
  ASSERT_TRUE(rectifier.passes_through());
  const auto left = test::image(64, 48, [](int u, int v) { return static_cast<std::uint8_t>(u ^ v); });
  const auto right = test::image(64, 48, [](int u, int v) { return static_cast<std::uint8_t>(u + v); });
  hal::GrayImage left_out, right_out;
  rectifier.rectify(left, right, left_out, right_out);
  EXPECT_EQ(left_out.pixels, left.pixels);
  EXPECT_EQ(right_out.pixels, right.pixels);
  EXPECT_DOUBLE_EQ(rectifier.rig().disparity_offset, 5);

  const Vector3d point(0.1, 0.05, 2);
  const double d = rig.left.project(point).x() - rig.right.project(rig.right_from_left * point).x();
  EXPECT_NEAR(rectifier.rig().depth(d), 2, 1e-12);
  EXPECT_EQ(disparity_range(rectifier.rig()).lowest, -5);
}

TEST(Rectifier, ShrinksTheImageAndKeepsTheView) {
  const StereoRig rig = ideal_rig();
  const Rectifier full(rig), half(rig, 0.5);
  EXPECT_EQ(half.camera().width, 32);
  EXPECT_EQ(half.camera().height, 24);
  EXPECT_NEAR(half.camera().focal, full.camera().focal / 2, 0.02 * full.camera().focal);
  EXPECT_FALSE(half.passes_through());
}

TEST(Rectifier, RefusesUnusableRigsAndScales) {
  StereoRig rig = ideal_rig();
  EXPECT_THROW(Rectifier(rig, 0), InputError);
  EXPECT_THROW(Rectifier(rig, NAN), InputError);
  rig.right_from_left.translation().x() = 0.1;
  EXPECT_THROW(Rectifier{rig}, InputError);
}

}  // namespace
}  // namespace headway::vision
