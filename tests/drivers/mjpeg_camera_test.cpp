// A camera that sends JPEG images, some of them broken.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/drivers/camera_bench.h"

namespace headway::drivers {
namespace {

using hal::CameraState;

class MjpegCamera : public ::testing::Test {
 protected:
  MjpegCamera() {
    bench_.device->paint = [this](std::span<std::uint8_t> buffer, std::uint32_t number) {
      std::vector<std::uint8_t> data;
      cv::imencode(".jpg", cv::Mat(24, 32, CV_8UC1, cv::Scalar(number % 200)), data);
      if (is_broken_) data.resize(data.size() * 9 / 10);
      std::copy(data.begin(), data.end(), buffer.begin());
      return data.size();
    };
    bench_.start();
  }
  testing::CameraBench bench_{PixelFormat::kMjpeg};
  bool is_broken_ = false;
};

TEST_F(MjpegCamera, IsDecodedFrameByFrame) {
  for (int i = 0; i < 100; ++i) {
    bench_.step();
    ASSERT_NEAR(bench_.image.pixels[400], bench_.device->made, 1);
  }
  EXPECT_GT(bench_.taken, 10);
  EXPECT_EQ(bench_.stats().damaged, 0u);
}

TEST_F(MjpegCamera, LosesOnlyTheFrameThatIsBroken) {
  const int before = bench_.taken;
  is_broken_ = true;
  bench_.run(seconds(0.04));
  is_broken_ = false;
  bench_.run(seconds(0.1));
  EXPECT_EQ(bench_.stats().damaged, 1u);
  EXPECT_EQ(bench_.taken, before + 3);
  EXPECT_EQ(bench_.stats().state, CameraState::kStreaming);
}

TEST_F(MjpegCamera, IsReadNoFurtherThanItsBufferThoughItsImageHasNoEnd) {
  is_broken_ = true;
  bench_.device->extra_bytes = 1 << 24;
  const int before = bench_.taken;
  bench_.run(seconds(0.2));
  EXPECT_EQ(bench_.taken, before);
  EXPECT_GT(bench_.stats().damaged, 2u);
}

TEST_F(MjpegCamera, IsDamagedWhileNothingCanBeDecoded) {
  is_broken_ = true;
  EXPECT_TRUE(bench_.run_until(CameraState::kDamaged, seconds(0.2)));
  bench_.run(seconds(1));
  EXPECT_EQ(bench_.stats().state, CameraState::kDamaged);
  is_broken_ = false;
  EXPECT_TRUE(bench_.run_until(CameraState::kStreaming, seconds(0.1)));
  EXPECT_TRUE(bench_.calls.violations.empty());
}

}  // namespace
}  // namespace headway::drivers
