// Eyes that are shown one picture twice.
#include "runtime/eyes.h"

#include <limits>

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

}  // namespace
}  // namespace headway::runtime
