#include "vision/characterise.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/source_dir/source_dir.h"
#include "tests/vision/random_rig.h"
#include "vision/hull.h"
#include "vision/rectify.h"
#include "vision/rig_files.h"

namespace headway::vision {
namespace {

TEST(Characterise, AgreesWithItselfOnEachOfOurRigs) {
  struct Ours {
    const char* file;
    PolytopeSize size;
  };
  // The images of the last one came rectified with principal points apart: beyond the depth where its middle
  // columns cross, the other image bounds each side.
  for (const auto& [file, size] : {Ours{"hrp2/rigs/bottom.yaml", {6, 8}},
                                   {"hrp2/rigs/bottom_640.yaml", {6, 8}},
                                   {"rigs/middlebury_motorcycle.yaml", {8, 12}}}) {
    const StereoRig rig = read_rig(source_dir() / "config" / file);
    const Rectifier rectifier(rig);
    const Characteristics c = characterise(rectifier, {0.02, 0.05, 1});
    EXPECT_TRUE(is_minimal(c.field)) << file;
    EXPECT_TRUE(is_minimal(c.pairs.minimal, 1e-6)) << file;
    EXPECT_EQ(c.rectified_sizes[2].rows, size.rows) << file;
    EXPECT_EQ(c.rectified_sizes[2].corners, size.corners) << file;
    EXPECT_GT(c.padded_share, 0) << file;
    EXPECT_LT(c.padded_share, 0.5) << file;
    for (const SightAt& s : c.sights) EXPECT_NEAR(s.measured / s.on_axis, 1, 0.05) << file;
    ASSERT_EQ(c.resolved.size(), 3U) << file;
    EXPECT_LT(c.resolved[0].farthest, c.resolved[1].farthest) << file;
    EXPECT_NEAR(c.resolved[2].farthest, rig.farthest, 1e-9) << file;
  }
}

// With the cameras turned towards each other all four sides of both images bound the field; near and far make
// ten.
TEST(Characterise, CountsTheHalfSpacesOfAVergedRig) {
  StereoRig rig;
  rig.name = "verged";
  rig.left = {};
  rig.left.width = 640, rig.left.height = 480, rig.left.fx = rig.left.fy = 600;
  rig.left.cx = 319.5, rig.left.cy = 239.5;
  rig.right = rig.left;
  rig.right_from_left.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()));
  rig.right_from_left.translation() << -0.2, 0, 0;
  rig.nearest = 0.8, rig.farthest = 6;
  const Rectifier rectifier(rig);
  const Characteristics c = characterise(rectifier, {});
  EXPECT_EQ(c.mounted_sizes[2].rows, 10U);
  EXPECT_EQ(c.mounted_sizes[2].corners, 16U);
}

/// Looks at the point that a raw pixel of the left image shows at a depth: whether the field holds it, and
/// whether both rectified images show it. Nothing where that is on the very rim, or where the right lens does
/// not see it.
struct HeldAndShown {
  bool held, shown;
};
std::optional<HeldAndShown> looked_at(const Rectifier& rectifier, const Polytope& field,
                                      const Eigen::Vector2d& left, double depth) {
  const StereoRig& rig = rectifier.raw();
  const auto ray = rig.left.unproject(left);
  if (!ray || ray->z() < 0.1) return std::nullopt;
  const Eigen::Vector3d point = *ray * (depth / ray->z()), from_right = rig.right_from_left * point;
  if (!(from_right.z() > 0.1 * depth)) return std::nullopt;
  const Eigen::Vector2d right = rig.right.project(from_right);
  const auto back = rig.right.unproject(right);
  if (!back || !back->isApprox(from_right.normalized(), 1e-6)) return std::nullopt;
  const PinholeCamera& c = rectifier.camera();
  double inside = std::numeric_limits<double>::infinity();  // [px] of the rectified images' rims
  for (const Eigen::Vector2d& at : {rectifier.rectified_left(left), rectifier.rectified_right(right)}) {
    if (!at.allFinite()) return std::nullopt;
    inside = std::min({inside, at.x() + 0.5, at.y() + 0.5, c.width - 0.5 - at.x(), c.height - 0.5 - at.y()});
  }
  if (std::abs(inside) < 1e-4) return std::nullopt;
  return HeldAndShown{field.contains(rectifier.rectified_from_left() * point), inside > 0};
}

TEST(Field, HoldsThePixelPairsThatOurRigsRectifiedImagesShowAndNoOthers) {
  const Rectifier rectifier(read_rig(source_dir() / "config/hrp2/rigs/bottom.yaml"));
  ASSERT_TRUE(rectifier.raw().left.distorts());
  const Polytope field = rig_polytope(rectifier.rig(), {});
  int shown = 0, cut_off = 0;
  for (int v = 0; v < rectifier.raw().left.height; v += 6)
    for (int u = 0; u < rectifier.raw().left.width; u += 6)
      for (const double depth : {0.8, 1.5, 3.0, 6.0})
        if (const auto at = looked_at(rectifier, field, {u, v}, depth)) {
          EXPECT_EQ(at->held, at->shown) << u << ", " << v << " at " << depth;
          ++(at->shown ? shown : cut_off);
        }
  EXPECT_GT(shown, 10000);
  EXPECT_GT(cut_off, 100) << "the raw images show more at their rims";
}

RC_GTEST_PROP(Field, HoldsWhatBothRectifiedImagesShowForAnyLens, ()) {
  const StereoRig rig = test::random_rig(test::any_lens());
  const Rectifier rectifier(rig);
  const Polytope field = rig_polytope(rectifier.rig(), {});
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d left(test::between(0, rig.left.width - 1), test::between(0, rig.left.height - 1));
    const auto at = looked_at(rectifier, field, left, rig.baseline() * test::between(2, 60));
    if (at) RC_ASSERT(at->held == at->shown);
  }
}

TEST(MeasuredResolution, IsWhatTheFormulaSaysWhileErrorsAreSmall) {
  RectifiedRig rig{{340, 480, 574, 169.5, 239.5}, 0.144, 0, 0.8, 6};
  for (const double z : {0.8, 1.5, 3.0, 6.0})
    EXPECT_NEAR(measured_resolution(rig, z, 40000) / resolution(rig, {0.072, 0, z}), 1, 0.02) << z;
}

TEST(Volume, OfABoxIsItsSidesProduct) {
  EXPECT_NEAR(volume(hull_polytope(
                  {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {2, 3, 0}, {0, 0, 4}, {2, 0, 4}, {0, 3, 4}, {2, 3, 4}})),
              24, 1e-12);
}

}  // namespace
}  // namespace headway::vision
