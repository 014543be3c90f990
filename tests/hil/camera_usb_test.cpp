// The camera driver on the kernel's uvcvideo. HEADWAY_VIDEO names the device of a USB camera of 320 x 240
// grey pixels; commands to it go line by line into the pipe HEADWAY_CAMERA_COMMANDS. Nothing here asserts how
// fast anything is: the machine may be emulated.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "drivers/v4l2_camera.h"
#include "hal/clock.h"
#include "tests/held.h"

namespace headway::drivers {
namespace {

constexpr Duration kPatience = std::chrono::seconds(60);

class UsbCamera : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* device = std::getenv("HEADWAY_VIDEO");
    const char* pipe = std::getenv("HEADWAY_CAMERA_COMMANDS");
    if (!device || !pipe) GTEST_SKIP() << "HEADWAY_VIDEO and HEADWAY_CAMERA_COMMANDS name no camera";
    config_.path = device;
    config_.width = 320;
    config_.height = 240;
    config_.format = PixelFormat::kGrey;
    config_.retry = {.first = std::chrono::milliseconds(50), .longest = std::chrono::milliseconds(50)};
    pipe_ = pipe;
  }

  void tell(const std::string& command) const { std::ofstream(pipe_) << command << std::endl; }
  bool until(const std::function<bool()>& done) {
    for (const Time end = clock_.now() + kPatience; clock_.now() < end;) {
      if (done()) return true;
      clock_.sleep_until(clock_.now() + std::chrono::milliseconds(5));
    }
    return false;
  }
  bool until_state(hal::CameraState state) {
    return until([&] {
      camera_->poll();
      return camera_->stats().state == state;
    });
  }
  /// Waits for the kernel to have cleared up before the driver closes its file: the other way round can bring
  /// the kernel down (uvcvideo of Linux 6.1).
  bool unplug() {
    tell("unplug");
    return until([] { return !std::filesystem::exists("/sys/bus/usb/devices/1-1"); });
  }

  hal::MonotonicClock clock_;
  V4l2CameraConfig config_;
  std::optional<V4l2Camera> camera_;

 private:
  std::string pipe_;
};

TEST_F(UsbCamera, HoldsNothingMoreAfterFiftyUnplugs) {
  const Held while_closed = held_now();
  camera_.emplace(config_, clock_);
  ASSERT_TRUE(until_state(hal::CameraState::kStreaming));
  const Held while_open = held_now();
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(unplug()) << i;
    ASSERT_TRUE(until_state(hal::CameraState::kGone)) << i;
    ASSERT_EQ(held_now(), while_closed) << i;
    tell("plug");
    ASSERT_TRUE(until_state(hal::CameraState::kStreaming)) << i;
    ASSERT_EQ(held_now(), while_open) << i;
  }
  camera_.reset();
  EXPECT_EQ(held_now(), while_closed);
}

}  // namespace
}  // namespace headway::drivers
