#include "vision/characterise.h"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/source_dir/source_dir.h"
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
    const Characteristics c =
        characterise(rig, rectifier.rig(), rectifier.rectified_from_left(), {0.02, 0.05, 1});
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
  const Characteristics c = characterise(rig, rectifier.rig(), rectifier.rectified_from_left(), {});
  EXPECT_EQ(c.mounted_sizes[2].rows, 10U);
  EXPECT_EQ(c.mounted_sizes[2].corners, 16U);
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
