// A camera that works: its frames, their stamps and their numbers.
#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "drivers/v4l2_depth_camera.h"
#include "hal/error.h"
#include "tests/drivers/camera_bench.h"

namespace headway::drivers {
namespace {

using hal::CameraState;
using testing::CameraBench, testing::ScriptedCamera;

TEST(V4l2Camera, DeliversEveryFrameInOrderWhenItIsAskedOftenEnough) {
  CameraBench bench;
  std::uint64_t last = 0;
  bench.on_frame = [&](const V4l2Camera::Waiting& frame) {
    EXPECT_EQ(frame.sequence, last + 1);
    last = frame.sequence;
  };
  bench.start();
  bench.run(seconds(2));
  EXPECT_EQ(bench.stats().state, CameraState::kStreaming);
  EXPECT_EQ(bench.taken, static_cast<int>(bench.device->made));
  EXPECT_GE(bench.taken, 58);
  EXPECT_EQ(bench.stats().lost + bench.stats().skipped + bench.stats().damaged, 0u);
  EXPECT_EQ(bench.image.pixels, std::vector<std::uint8_t>(32 * 24, static_cast<std::uint8_t>(bench.taken)));
}

TEST(V4l2Camera, CopiesBeforeTheDriverMayWriteAgain) {
  // The scripted driver spoils a buffer at the moment in which it gets it back.
  CameraBench bench;
  bench.start();
  for (int i = 0; i < 100; ++i) {
    bench.step();
    const std::uint8_t first = bench.image.pixels.front();
    ASSERT_EQ(std::count(bench.image.pixels.begin(), bench.image.pixels.end(), first), 32 * 24);
    ASSERT_LT(first, 200);
  }
}

TEST(V4l2Camera, TakesTheNewestWhenItIsLateAndCountsTheOthers) {
  CameraBench bench;
  bench.start();
  bench.run(seconds(1));
  const auto before = bench.stats();
  const int taken = bench.taken;
  bench.step(seconds(0.1));  // three periods
  EXPECT_EQ(bench.taken, taken + 1);
  EXPECT_EQ(bench.stats().skipped, before.skipped + 2);
  EXPECT_EQ(bench.stats().lost, before.lost);
  EXPECT_EQ(bench.image.pixels.front(), bench.device->made);
}

TEST(V4l2Camera, CountsWhatTheDriverHadNoBufferFor) {
  CameraBench bench;
  bench.start();
  bench.run(seconds(1));
  bench.step(seconds(0.335));  // ten periods, four buffers
  bench.run(seconds(0.2));
  EXPECT_EQ(bench.stats().lost, 6u);
  EXPECT_EQ(bench.stats().usable + bench.stats().lost, bench.device->made);
}

TEST(V4l2Camera, StampsTheMiddleOfTheExposure) {
  for (const bool at_start : {false, true}) {
    CameraBench bench;
    bench.device->stamps_at_start = at_start;
    bench.config.readout = bench.device->readout = std::chrono::milliseconds(7);
    int frames = 0;
    bench.on_frame = [&](const V4l2Camera::Waiting& frame) {
      // V4L2 stamps in microseconds.
      EXPECT_LE(std::chrono::abs(frame.exposure - bench.device->middles.back()),
                std::chrono::microseconds(1));
      ++frames;
    };
    bench.start();
    bench.run(seconds(1));
    EXPECT_GT(frames, 25);
  }
}

TEST(V4l2Camera, ReadsRowsWithPadding) {
  CameraBench bench(PixelFormat::kYuyv);
  bench.device->padding = 24;
  bench.device->paint = [](std::span<std::uint8_t> buffer, std::uint32_t) {
    std::fill(buffer.begin(), buffer.end(), 255);
    for (std::size_t y = 0; y < 24; ++y) {
      for (std::size_t x = 0; x < 32; ++x)
        buffer[y * (64 + 24) + 2 * x] = static_cast<std::uint8_t>(4 * y + x);
    }
    return buffer.size() - 24;
  };
  bench.start();
  for (std::size_t i = 0; i < bench.image.pixels.size(); ++i)
    ASSERT_EQ(bench.image.pixels[i], 4 * (i / 32) + i % 32);
  EXPECT_EQ(bench.image.pixels.size(), 32u * 24);
}

TEST(V4l2Camera, CountsGapsAndGoesOnWhenTheCountBeginsAnew) {
  CameraBench bench;
  bench.start();
  bench.device->lose = 2;
  bench.run(seconds(0.3));
  EXPECT_EQ(bench.stats().lost, 2u);
  bench.device->count_anew = true;
  bench.run(seconds(0.3));
  EXPECT_EQ(bench.stats().lost, 2u);
  EXPECT_EQ(bench.stats().state, CameraState::kStreaming);
}

TEST(V4l2Camera, ClosesWhatItOpened) {
  CameraBench bench;
  bench.start();
  bench.camera.reset();
  EXPECT_EQ(bench.calls.open_descriptors(), 0u);
  EXPECT_EQ(bench.calls.mappings(), 0u);
  EXPECT_TRUE(bench.calls.violations.empty());
}

class DepthBench : public ::testing::Test {
 protected:
  DepthBench() {
    clock_.set(at_seconds(100));
    device_ = &calls_.add(testing::kEye, ScriptedCamera(PixelFormat::kZ16));
    config_.exposure.reset();
  }
  hal::ManualClock clock_;
  testing::ScriptedCalls calls_{clock_};
  ScriptedCamera* device_;
  V4l2CameraConfig config_ = testing::small_config(PixelFormat::kGrey);
};

TEST_F(DepthBench, FramesAreMetresWithNothingWhereNothingWasMeasured) {
  device_->paint = [](std::span<std::uint8_t> buffer, std::uint32_t number) {
    for (std::size_t i = 0; i < buffer.size() / 2; ++i) {
      const auto count = static_cast<std::uint16_t>(i == 5 ? 0 : 1000 * number + i);
      buffer[2 * i] = static_cast<std::uint8_t>(count & 0xFF);
      buffer[2 * i + 1] = static_cast<std::uint8_t>(count >> 8);
    }
    return buffer.size();
  };
  config_.metres_per_count = 0.0005;
  V4l2DepthCamera camera(config_, clock_, calls_);
  hal::DepthFrame frame;
  EXPECT_FALSE(camera.take_newest(frame));
  EXPECT_EQ(camera.state(), CameraState::kStarting);
  clock_.advance(seconds(0.34));  // the second frame
  ASSERT_TRUE(camera.take_newest(frame));
  EXPECT_EQ(frame.width, 32);
  EXPECT_EQ(frame.height, 24);
  EXPECT_EQ(frame.sequence, 2u);
  EXPECT_LE(std::chrono::abs(frame.exposure - device_->middles.back()), std::chrono::microseconds(1));
  EXPECT_NEAR(frame.depth[100], 1.050, 1e-6);
  EXPECT_TRUE(std::isnan(frame.depth[5]));
  EXPECT_FALSE(camera.take_newest(frame));
  EXPECT_EQ(camera.state(), CameraState::kStreaming);
}

TEST_F(DepthBench, RefusesACameraWithoutDepth) {
  calls_.add(testing::kEye, ScriptedCamera(PixelFormat::kGrey));
  EXPECT_THROW(V4l2DepthCamera(config_, clock_, calls_), InputError);
}

}  // namespace
}  // namespace headway::drivers
