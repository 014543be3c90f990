#include "drivers/v4l2_exposure.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "tests/drivers/scripted_camera.h"

namespace headway::drivers {
namespace {

struct V4l2ExposureTest : ::testing::Test {
  hal::ManualClock clock;
  testing::ScriptedCalls calls{clock};
  testing::ScriptedCamera& camera = calls.add("/dev/video0", testing::ScriptedCamera(PixelFormat::kGrey));

  void TearDown() override {
    EXPECT_EQ(calls.open_descriptors(), 0u);
    EXPECT_TRUE(calls.violations.empty());
  }
};

TEST_F(V4l2ExposureTest, IsReadWithItsAutomatic) {
  const auto automatic = present_exposure(calls, "/dev/video0");
  ASSERT_TRUE(automatic);
  EXPECT_EQ(automatic->time, std::chrono::milliseconds(25));
  EXPECT_TRUE(automatic->is_automatic);
  camera.controls[V4L2_CID_EXPOSURE_AUTO].value = V4L2_EXPOSURE_MANUAL;
  camera.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value = 80;
  const auto by_hand = present_exposure(calls, "/dev/video0");
  EXPECT_EQ(by_hand->time, std::chrono::milliseconds(8));
  EXPECT_FALSE(by_hand->is_automatic);
  EXPECT_FALSE(by_hand->may_slow_down);
}

TEST_F(V4l2ExposureTest, MaySlowTheCameraDownUnlessThatIsForbidden) {
  EXPECT_TRUE(present_exposure(calls, "/dev/video0")->may_slow_down) << "nothing is said about it";
  camera.controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY] = {.least = 0, .most = 1, .step = 1, .value = 1};
  EXPECT_TRUE(present_exposure(calls, "/dev/video0")->may_slow_down);
  camera.controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY].value = 0;
  EXPECT_FALSE(present_exposure(calls, "/dev/video0")->may_slow_down);
}

TEST_F(V4l2ExposureTest, IsUnknownOfACameraWithoutTheControlAndOfNone) {
  camera.controls.clear();
  const auto unknown = present_exposure(calls, "/dev/video0");
  ASSERT_TRUE(unknown);
  EXPECT_FALSE(unknown->time);
  EXPECT_FALSE(unknown->may_slow_down);
  EXPECT_FALSE(present_exposure(calls, "/dev/video7"));
}

}  // namespace
}  // namespace headway::drivers
