// The camera driver on the kernel's uvcvideo. HEADWAY_VIDEO names the device of a USB camera of 320 x 240
// pixels, grey or, where a test says so, distances; commands to it go line by line into the pipe
// HEADWAY_CAMERA_COMMANDS, and HEADWAY_FILMED is the file of its frames. Nothing here asserts how fast
// anything is: the machine may be emulated.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "drivers/v4l2_camera.h"
#include "drivers/v4l2_depth_camera.h"
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
  EXPECT_GT(while_open.camera_buffers, while_closed.camera_buffers);
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

class UsbDepthCamera : public UsbCamera {};

TEST_F(UsbDepthCamera, ReadsTheDistancesThatWereFilmed) {
  const char* filmed = std::getenv("HEADWAY_FILMED");
  ASSERT_TRUE(filmed) << "HEADWAY_FILMED names no file";
  std::ifstream file(filmed, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  const std::size_t pixels = 320 * 240;
  ASSERT_GE(bytes.size(), 2 * pixels);
  config_.metres_per_count = 0.0005;
  V4l2DepthCamera camera(config_, clock_);
  hal::DepthFrame frame;
  ASSERT_TRUE(until([&] { return camera.take_newest(frame); }));
  ASSERT_EQ(frame.depth.size(), pixels);
  const auto is_frame = [&](std::size_t begin) {
    for (std::size_t i = 0; i < pixels; ++i) {
      const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(bytes[begin + 2 * i + at]); };
      const int counts = byte(0) + 256 * byte(1);
      const auto metres = static_cast<double>(frame.depth[i]);
      const bool fits = counts == 0 ? std::isnan(metres) : std::abs(metres - 0.0005 * counts) < 1e-5;
      if (!fits) return false;
    }
    return true;
  };
  bool found = false;
  for (std::size_t begin = 0; begin < bytes.size() && !found; begin += 2 * pixels) found = is_frame(begin);
  EXPECT_TRUE(found) << "it is none of those that the camera was given";
}

}  // namespace
}  // namespace headway::drivers
