// How a camera is opened and set, and what is said when it cannot be.
#include <cerrno>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "hal/error.h"
#include "tests/drivers/camera_bench.h"

namespace headway::drivers {
namespace {

using ::testing::AllOf, ::testing::HasSubstr;
using testing::Call, testing::CameraBench, testing::ScriptedCamera;

/// What opening says; empty when all is well.
std::string refusal(CameraBench& bench) {
  try {
    bench.open();
  } catch (const Error& error) {
    EXPECT_EQ(bench.calls.open_descriptors(), 0u);
    EXPECT_EQ(bench.calls.mappings(), 0u);
    return error.what();
  }
  return "";
}

TEST(V4l2Setup, SetsEverythingBeforeTheFirstFrame) {
  CameraBench bench;
  bench.config.gain = 20;
  bench.config.white_balance = 4600;
  bench.open();
  const auto& controls = bench.device->controls;
  EXPECT_EQ(bench.device->set->width, 32);
  EXPECT_EQ(bench.device->rate, 30);
  EXPECT_EQ(controls.at(V4L2_CID_EXPOSURE_AUTO).value, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(controls.at(V4L2_CID_EXPOSURE_ABSOLUTE).value, 80);
  EXPECT_EQ(controls.at(V4L2_CID_AUTOGAIN).value, 0);
  EXPECT_EQ(controls.at(V4L2_CID_GAIN).value, 20);
  EXPECT_EQ(controls.at(V4L2_CID_AUTO_WHITE_BALANCE).value, 0);
  EXPECT_EQ(controls.at(V4L2_CID_WHITE_BALANCE_TEMPERATURE).value, 4600);
  EXPECT_EQ(bench.device->control_calls, 1);
  EXPECT_EQ(bench.calls.mappings(), 4u);
  EXPECT_EQ(bench.camera->settings().exposure, seconds(0.008));
  EXPECT_EQ(bench.camera->settings().period, seconds(1.0 / 30));
  EXPECT_EQ(bench.stats().state, hal::CameraState::kStarting);
}

TEST(V4l2Setup, LeavesAutomaticsAloneWhereNothingIsAsked) {
  CameraBench bench;
  bench.config.exposure.reset();
  bench.config.rate.reset();
  bench.open();
  EXPECT_EQ(bench.device->control_calls, 0);
  EXPECT_EQ(bench.device->controls.at(V4L2_CID_EXPOSURE_AUTO).value, V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_FALSE(bench.camera->settings().exposure);
  EXPECT_EQ(bench.camera->settings().period, seconds(1.0 / 30));
}

TEST(V4l2Setup, DoesWithoutAnAutomaticThatTheCameraLacks) {
  CameraBench bench;
  bench.config.gain = 20;
  bench.device->controls.erase(V4L2_CID_AUTOGAIN);
  EXPECT_EQ(refusal(bench), "");
  EXPECT_EQ(bench.device->controls.at(V4L2_CID_GAIN).value, 20);
}

TEST(V4l2Setup, TakesAValueRoundedToTheCamerasStep) {
  CameraBench bench;
  bench.config.white_balance = 4604;
  EXPECT_EQ(refusal(bench), "");
  EXPECT_EQ(bench.device->controls.at(V4L2_CID_WHITE_BALANCE_TEMPERATURE).value, 4600);
}

TEST(V4l2Setup, SaysWhatTheCameraOffersWhenItGivesAnotherFormat) {
  CameraBench bench;
  bench.device->offers.push_back({V4L2_PIX_FMT_YUYV, 64, 48, 15});
  bench.device->offers.push_back({V4L2_PIX_FMT_RGB24, 64, 48, 15});
  bench.config.width = 64;
  EXPECT_THAT(refusal(bench),
              AllOf(HasSubstr(testing::kEye), HasSubstr("asked for 64 x 24 px of GREY"),
                    HasSubstr("gives 32 x 24 px of GREY"), HasSubstr("YUYV 64 x 48 (15, 7.5 /s)"),
                    HasSubstr("that Headway does not read: RGB3")));
}

TEST(V4l2Setup, RefusesInterlacedImages) {
  CameraBench bench;
  bench.device->interlaced = true;
  EXPECT_THAT(refusal(bench), HasSubstr("interlaced"));
}

TEST(V4l2Setup, RefusesARateThatWasSilentlyChanged) {
  CameraBench bench;
  bench.device->offers[0].most_rate = 25;
  EXPECT_THAT(refusal(bench),
              AllOf(HasSubstr("asked for 30 frames/s, and gives 25"), HasSubstr("it offers")));
}

TEST(V4l2Setup, TakesTheCamerasOwnRateWhereNobodyCanSetIt) {
  CameraBench bench;
  bench.device->can_set_rate = false;
  EXPECT_EQ(refusal(bench), "");
  EXPECT_EQ(bench.camera->period(), seconds(1.0 / 30));
}

TEST(V4l2Setup, NamesAControlThatIsMissingOrDeafOrRefused) {
  CameraBench missing;
  missing.device->controls.erase(V4L2_CID_EXPOSURE_ABSOLUTE);
  EXPECT_THAT(refusal(missing), AllOf(HasSubstr("no control for exposure"), HasSubstr("leave")));
  CameraBench deaf;
  deaf.device->deaf_to = {V4L2_CID_EXPOSURE_ABSOLUTE};
  EXPECT_THAT(refusal(deaf),
              HasSubstr("told to set exposure [0.1 ms] to 80, and has 250; its range is 3 to 2047"));
  CameraBench beyond;
  beyond.config.gain = 500;
  EXPECT_THAT(refusal(beyond), HasSubstr("told to set gain to 500, and has 255"));
  CameraBench stubborn;
  stubborn.device->deaf_to = {V4L2_CID_EXPOSURE_AUTO};
  EXPECT_THAT(refusal(stubborn), HasSubstr("refuses to set exposure"));
  CameraBench busy;
  busy.device->fails[Call::kControls] = EBUSY;
  EXPECT_THAT(refusal(busy), HasSubstr("another program"));
}

TEST(V4l2Setup, SaysThatUsbHasNoBandwidthLeftAndWhatHelps) {
  CameraBench bench;
  bench.device->fails[Call::kStart] = ENOSPC;
  EXPECT_THAT(refusal(bench), AllOf(HasSubstr("bandwidth"), HasSubstr("lower rate"), HasSubstr("MJPEG"),
                                    HasSubstr("another USB controller")));
}

TEST(V4l2Setup, TellsAMissingCameraFromAForbiddenOrAUsedOne) {
  CameraBench gone;
  gone.device->unplug();
  EXPECT_THAT(refusal(gone), HasSubstr("plugged in"));
  CameraBench forbidden;
  forbidden.device->fails[Call::kOpen] = EACCES;
  EXPECT_THAT(refusal(forbidden), HasSubstr("group"));
  CameraBench used;
  used.device->fails[Call::kRequest] = EBUSY;
  EXPECT_THAT(refusal(used), HasSubstr("used by another program"));
}

TEST(V4l2Setup, RefusesWhatIsNoCameraThatStreams) {
  for (const std::uint32_t can : {V4L2_CAP_VIDEO_OUTPUT, V4L2_CAP_VIDEO_CAPTURE, V4L2_CAP_STREAMING}) {
    CameraBench bench;
    bench.device->capabilities = static_cast<std::uint32_t>(can);
    EXPECT_THAT(refusal(bench), HasSubstr("no camera that streams"));
  }
  CameraBench no_v4l2;
  no_v4l2.device->fails[Call::kCapability] = ENOTTY;
  EXPECT_THAT(refusal(no_v4l2), HasSubstr("no V4L2 device"));
}

TEST(V4l2Setup, RefusesStampsOfAnotherClockAndTooFewBuffers) {
  CameraBench stamps;
  stamps.device->foreign_clock = true;
  EXPECT_THAT(refusal(stamps), HasSubstr("CLOCK_MONOTONIC"));
  CameraBench buffers;
  buffers.device->fewest_buffers = 2;
  EXPECT_THAT(refusal(buffers), HasSubstr("fewer than the buffers"));
}

TEST(V4l2Setup, LeavesNothingOpenWhicheverCallFails) {
  for (int call = 0; call < testing::kCalls; ++call) {
    if (Call(call) == Call::kDequeue || Call(call) == Call::kStop || Call(call) == Call::kPoll) continue;
    CameraBench bench;
    bench.device->fails[Call(call)] = EIO;
    EXPECT_NE(refusal(bench), "") << call;
    EXPECT_TRUE(bench.calls.violations.empty()) << bench.calls.violations.front();
  }
}

TEST(V4l2Setup, RefusesSettingsThatNoCameraCouldHave) {
  const auto refuses = [](auto spoil) {
    CameraBench bench;
    spoil(bench.config);
    const std::string said = refusal(bench);
    return bench.calls.calls == 0 && said.find("expected") != std::string::npos;
  };
  EXPECT_TRUE(refuses([](V4l2CameraConfig& c) { c.path = ""; }));
  EXPECT_TRUE(refuses([](V4l2CameraConfig& c) { c.width = 0; }));
  EXPECT_TRUE(refuses([](V4l2CameraConfig& c) { c.rate = 0; }));
  EXPECT_TRUE(refuses([](V4l2CameraConfig& c) { c.exposure = seconds(0.04); }));
  EXPECT_TRUE(refuses([](V4l2CameraConfig& c) { c.gain = -1; }));
  EXPECT_TRUE(refuses([](V4l2CameraConfig& c) { c.white_balance = 0; }));
  EXPECT_TRUE(refuses([](V4l2CameraConfig& c) { c.y16_bits = 7; }));
  EXPECT_TRUE(refuses([](V4l2CameraConfig& c) { c.retry.longest = seconds(0.1); }));
}

TEST(KernelCalls, GiveErrorsAsNegativeNumbers) {
  DeviceCalls& kernel = kernel_calls();
  EXPECT_EQ(kernel.open("/dev/video-that-is-not-there"), -ENOENT);
  v4l2_capability capability{};
  EXPECT_EQ(kernel.ioctl(-1, VIDIOC_QUERYCAP, &capability), -EBADF);
  EXPECT_EQ(kernel.mmap(-1, 4096, 0).error, EBADF);
  EXPECT_EQ(kernel.close(-1), -EBADF);
}

TEST(KernelCalls, OpenForReadingAndWritingWithoutBlockingAndNotForChildren) {
  DeviceCalls& kernel = kernel_calls();
  const int null = kernel.open("/dev/null");
  ASSERT_GE(null, 0);
  EXPECT_EQ(::fcntl(null, F_GETFL) & (O_ACCMODE | O_NONBLOCK), O_RDWR | O_NONBLOCK);
  EXPECT_EQ(::fcntl(null, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
  v4l2_capability capability{};
  EXPECT_EQ(kernel.ioctl(null, VIDIOC_QUERYCAP, &capability), -ENOTTY);
  EXPECT_EQ(kernel.close(null), 0);
}

}  // namespace
}  // namespace headway::drivers
