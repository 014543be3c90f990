// Eyes that are shown one picture twice.
#include "runtime/eyes.h"

#include <array>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace headway::runtime {
namespace {

class ShownDepth final : public hal::DepthCamera {
 public:
  bool take_newest(hal::DepthFrame& into) override {
    into = {Time(seconds(0.1) * ++shown), shown, 8, 6, depth};
    return true;
  }
  std::vector<float> depth = std::vector<float>(48, 2.0F);

 private:
  std::uint64_t shown = 0;
};

struct Bench {
  ShownDepth camera;
  DepthEyes eyes{camera,
                 {.camera = {8, 6, 5, 3.5, 2.5},
                  .sigma = vision::StereoDepthSigma{1, 0.01},
                  .left_from_view = Eigen::Isometry3d::Identity()}};
  std::string look() {
    EXPECT_TRUE(eyes.take());
    eyes.see();
    return eyes.fault();
  }
};

TEST(DepthEyes, TakeTheSamePictureAgainForAFrozenCamera) {
  Bench bench;
  EXPECT_EQ(bench.look(), "");
  EXPECT_EQ(bench.look(), kFrozen);
  EXPECT_EQ(bench.look(), kFrozen);
  bench.camera.depth[17] = 2.0001F;
  EXPECT_EQ(bench.look(), "") << "one pixel is enough";
}

TEST(DepthEyes, CallNoCameraFrozenThatMeasuresNothing) {
  Bench bench;
  bench.camera.depth.assign(48, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(bench.look(), "");
  EXPECT_EQ(bench.look(), "") << "covered, as its missing points say";
}

TEST(DepthEyes, KnowAFrozenPictureThatHasHoles) {
  Bench bench;
  bench.camera.depth[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(bench.look(), "");
  EXPECT_EQ(bench.look(), kFrozen);
}

/// A patterned wall a metre away, with a little noise in each new picture.
class ShownPair final : public hal::StereoCamera {
 public:
  static constexpr int kWidth = 160, kHeight = 120, kDisparity = 12;

  ShownPair() {
    left = new_left();
    right = new_right();
  }
  bool take_newest(hal::StereoFrame& into) override {
    into.exposure = Time(seconds(0.1) * ++shown);
    into.sequence = shown;
    into.left = left;
    into.right = right;
    return true;
  }
  hal::GrayImage new_left() { return picture(0); }
  hal::GrayImage new_right() { return picture(kDisparity); }

  hal::GrayImage left, right;

 private:
  hal::GrayImage picture(int shift) {
    std::mt19937 pattern(1);
    hal::GrayImage image{kWidth, kHeight, {}};
    for (int y = 0; y < kHeight; ++y) {
      std::array<unsigned, kWidth + kDisparity> row{};
      for (unsigned& pixel : row) pixel = 64 + pattern() % 128;
      for (int x = 0; x < kWidth; ++x)
        image.pixels.push_back(
            static_cast<std::uint8_t>(row[static_cast<std::size_t>(x + shift)] + noise_() % 3));
    }
    return image;
  }
  std::mt19937 noise_{2};
  std::uint64_t shown = 0;
};

vision::StereoRig small_rig() {
  vision::StereoRig rig;
  rig.left.width = rig.right.width = ShownPair::kWidth;
  rig.left.height = rig.right.height = ShownPair::kHeight;
  for (vision::CameraIntrinsics* eye : {&rig.left, &rig.right}) {
    eye->fx = eye->fy = 120;
    eye->cx = 79.5;
    eye->cy = 59.5;
  }
  rig.right_from_left = Eigen::Translation3d(-0.1, 0, 0);
  return rig;
}

struct PairBench {
  ShownPair camera;
  StereoEyes eyes{camera, small_rig(), {}};
  std::string look() {
    EXPECT_TRUE(eyes.take());
    eyes.see();
    return eyes.fault();
  }
};

TEST(StereoEyes, TakeTheSameLeftPictureAgainForAFrozenCamera) {
  PairBench bench;
  EXPECT_EQ(bench.look(), "");
  for (int i = 0; i < 3; ++i) {
    bench.camera.right = bench.camera.new_right();
    EXPECT_EQ(bench.look(), kFrozen);
  }
  bench.camera.left.pixels[17] ^= 1;
  bench.camera.right = bench.camera.new_right();
  EXPECT_EQ(bench.look(), "") << "one pixel is enough";
}

TEST(StereoEyes, TakeTheSameRightPictureAgainForAFrozenCamera) {
  PairBench bench;
  EXPECT_EQ(bench.look(), "");
  for (int i = 0; i < 3; ++i) {
    bench.camera.left = bench.camera.new_left();
    EXPECT_EQ(bench.look(), kFrozen);
  }
  bench.camera.right.pixels[17] ^= 1;
  bench.camera.left = bench.camera.new_left();
  EXPECT_EQ(bench.look(), "");
}

}  // namespace
}  // namespace headway::runtime
