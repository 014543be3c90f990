#include "vision/stereo.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/source_dir/source_dir.h"
#include "tests/vision/scene.h"
#include "vision/image_files.h"
#include "vision/rig_files.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;
using test::image;

StereoRig bottom() { return read_rig(source_dir() / "config/hrp2/rigs/bottom.yaml"); }

// How a view agrees with the plane `normal` . x = `offset` of the raw left frame.
struct Agreement {
  double density = 0, within_3_sigma = 0, z_rms = 0;
};

Agreement agreement(const StereoVision& vision, const RangeView& view, const Vector3d& normal,
                    double offset) {
  const Vector3d n = vision.left_from_rectified().linear().transpose() * normal;
  double seen = 0, inside = 0, squares = 0, all = 0;
  for (int v = 0; v < view.camera.height; ++v)
    for (int u = 0; u < view.camera.width; ++u) {
      const double truth = offset / n.dot(view.camera.point(u, v, 1));
      if (u - vision.rig().disparity(truth) < 0) continue;  // the right camera does not see it
      ++all;
      const double z = static_cast<double>(view.depth[view.index(u, v)]);
      if (std::isnan(z)) continue;
      ++seen;
      const double error = (z - truth) / static_cast<double>(view.sigma_depth[view.index(u, v)]);
      inside += std::abs(error) <= 3;
      squares += std::min(9.0, error * error);
    }
  return {seen / all, inside / seen, std::sqrt(squares / seen)};
}

// The bottom pair is distorted, askew and verged: only right rectification makes this come out.
TEST(StereoVision, MeasuresAPlaneThroughDistortedLenses) {
  StereoVision vision(bottom());
  for (const double distance : {1.0, 2.5, 5.0}) {
    const Vector3d normal = Vector3d(0.1, -0.2, 1).normalized();
    const RangeView& view = vision.see(test::plane_seen_by(bottom(), normal, distance));
    EXPECT_EQ(vision.fault(), "");
    const Agreement found = agreement(vision, view, normal, distance);
    EXPECT_GT(found.density, 0.95) << distance;
    EXPECT_GT(found.within_3_sigma, 0.99) << distance;
    EXPECT_LT(found.z_rms, 1) << distance;
  }
}

TEST(StereoVision, SeesNothingFarAwayInAWallThatIsTooNear) {
  const auto points = [](double search_nearer) {
    VisionConfig config;
    config.search_nearer = search_nearer;
    StereoVision vision(bottom(), config);
    const RangeView& view = vision.see(test::plane_seen_by(bottom(), Vector3d::UnitZ(), 0.65));
    return std::count_if(view.depth.begin(), view.depth.end(), [](float z) { return !std::isnan(z); });
  };
  EXPECT_EQ(points(0.7), 0);
  EXPECT_GT(points(1), 1000) << "without the longer search it has wrong partners";
}

TEST(StereoVision, MeasuresTheFloorFromHalfTheResolution) {
  VisionConfig config;
  config.scale = 0.5;
  StereoVision vision(bottom(), config);
  EXPECT_EQ(vision.camera().width, 170);
  EXPECT_EQ(disparity_range(vision.rig()).count, 64);
  const Vector3d floor = Vector3d(0, 0.7, 0.7).normalized();  // camera 45 deg down, 1.2 m above the floor
  const RangeView& view = vision.see(test::plane_seen_by(bottom(), floor, 1.2));
  const Agreement found = agreement(vision, view, floor, 1.2);
  EXPECT_GT(found.density, 0.9);
  EXPECT_GT(found.within_3_sigma, 0.99);
}

TEST(StereoVision, SaysWhichSizeItExpectedAndSeesNothing) {
  StereoVision vision(bottom());
  vision.see(test::plane_seen_by(bottom(), Vector3d::UnitZ(), 2));
  hal::StereoFrame frame;
  frame.left = image(320, 240, [](int, int) { return std::uint8_t{0}; });
  frame.right = frame.left;
  const RangeView& view = vision.see(frame);
  EXPECT_THAT(vision.fault(),
              testing::HasSubstr("320 x 240 and 320 x 240 px, expected 340 x 480 each, as in rig bottom"));
  ASSERT_EQ(view.depth.size(), 340U * 480U);
  for (const float z : view.depth) ASSERT_TRUE(std::isnan(z)) << "nothing of the frame before may stay";

  frame = test::plane_seen_by(bottom(), Vector3d::UnitZ(), 2);
  frame.right.pixels.pop_back();
  vision.see(frame);
  EXPECT_NE(vision.fault(), "");
  vision.see({});
  EXPECT_NE(vision.fault(), "");
}

TEST(StereoVision, SeesNoPointsInTheDark) {
  StereoVision vision(bottom());
  hal::StereoFrame dark;
  dark.left = dark.right = image(340, 480, [](int, int) { return std::uint8_t{3}; });
  for (const float z : vision.see(dark).depth) ASSERT_TRUE(std::isnan(z));
  EXPECT_EQ(vision.fault(), "");
}

TEST(StereoVision, NoticesThatACameraIsCoveredAndThatItIsNotAnyMore) {
  StereoVision vision(bottom());
  const hal::StereoFrame healthy = test::plane_seen_by(bottom(), Vector3d::UnitZ(), 2);
  hal::StereoFrame frame = healthy;
  vision.see(frame);
  EXPECT_GT(vision.sight().pair.found, 100);
  EXPECT_TRUE(vision.sight().findings.empty());
  frame.right = image(340, 480, [](int, int) { return std::uint8_t{30}; });
  vision.see(frame);
  ASSERT_NE(vision.sight().fault(), nullptr);
  EXPECT_TRUE(vision.sight().has(SightFault::kCovered));
  vision.see(healthy);
  EXPECT_EQ(vision.sight().fault(), nullptr);
}

TEST(StereoVision, NoticesARigThatWasBent) {
  StereoRig bent = bottom();
  bent.right_from_left.linear() = Eigen::AngleAxisd(0.003, Vector3d::UnitX()) * bent.right_from_left.linear();
  StereoVision vision(bottom());
  vision.see(test::plane_seen_by(bent, Vector3d(0.1, 0.2, 1).normalized(), 2));
  EXPECT_TRUE(vision.sight().has(SightFault::kDecalibrated));
  EXPECT_NEAR(vision.sight().pair.row_error, 0.003 * bent.left.fx, 0.3);
}

TEST(StereoVision, GivesTheSameBytesForTheSamePair) {
  const auto frame = test::plane_seen_by(bottom(), Vector3d(0.3, 0, 1).normalized(), 1.5);
  StereoVision one(bottom()), other(bottom());
  const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
  };
  const RangeView first = one.see(frame);
  EXPECT_TRUE(same(first.depth, other.see(frame).depth));
  one.see(test::plane_seen_by(bottom(), Vector3d::UnitZ(), 3));
  EXPECT_TRUE(same(first.depth, one.see(frame).depth)) << "what was seen before must not matter";
  EXPECT_TRUE(same(first.sigma_depth, one.see(frame).sigma_depth));
}

TEST(StereoVision, MatchesMostOfARealHall) {
  if (test::data_folder().empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
  const auto folder = test::data_folder() / "sequence/euroc";
  StereoVision vision(read_euroc_rig(folder));
  hal::StereoFrame frame;
  frame.left = read_gray(folder / "cam0/data/1403715274262142976.png");
  frame.right = read_gray(folder / "cam1/data/1403715274262142976.png");
  const RangeView& view = vision.see(frame);
  std::size_t matched = 0, used = 0;
  for (const float d : vision.disparity().values) matched += !std::isnan(d);
  for (const float z : view.depth) used += !std::isnan(z);
  const double all = static_cast<double>(view.depth.size());
  EXPECT_GT(static_cast<double>(matched) / all, 0.75);
  EXPECT_GT(static_cast<double>(used) / all, 0.7);
}

}  // namespace
}  // namespace headway::vision
