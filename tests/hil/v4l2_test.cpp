// The camera driver on the kernel's virtual camera (vivid), with the faults that it can be told to have.
// HEADWAY_VIDEO names its device; each test wants vivid loaded anew, since a fault stays armed. Needs root
// and v4l2-ctl. Nothing here asserts how fast anything is: the machine may be emulated.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/v4l2_camera.h"
#include "drivers/v4l2_listing.h"
#include "hal/clock.h"
#include "hal/error.h"
#include "tests/held.h"

namespace headway::drivers {
namespace {

namespace fs = std::filesystem;
using hal::CameraState;
using ::testing::AllOf, ::testing::HasSubstr;

constexpr Duration kPatience = std::chrono::seconds(60);

int run(const std::string& command) { return std::system(command.c_str()); }

class VividCamera : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* device = std::getenv("HEADWAY_VIDEO");
    if (!device) GTEST_SKIP() << "HEADWAY_VIDEO names no virtual camera";
    config_.path = device;
    config_.width = 320;
    config_.height = 180;
    config_.rate = 25;
  }

  void set(const std::string& control, int value) const {
    ASSERT_EQ(run(fmt::format("v4l2-ctl -d {} -c {}={}", config_.path, control, value)), 0) << control;
  }
  void open() { camera_.emplace(config_, clock_); }
  /// What opening says; empty when all is well.
  std::string refusal() {
    try {
      open();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  /// Polls and takes until it is done; false when that lasts too long.
  bool until(const std::function<bool()>& done) {
    for (const Time end = clock_.now() + kPatience; clock_.now() < end;) {
      if (done()) return true;
      clock_.sleep_until(clock_.now() + std::chrono::milliseconds(5));
      camera_->poll();
      while (camera_->waiting().size() > 1) camera_->skip();
      if (camera_->waiting().empty()) continue;
      const V4l2Camera::Waiting frame = camera_->waiting().front();
      EXPECT_GT(frame.sequence, sequence_);
      EXPECT_GT(frame.exposure, exposure_);
      EXPECT_LE(frame.exposure, clock_.now());
      sequence_ = frame.sequence;
      driver_sequence_ = frame.buffer.sequence;
      exposure_ = frame.exposure;
      if (camera_->take(image_)) ++taken_;
    }
    return false;
  }
  bool until_state(CameraState state) {
    return until([&] { return stats().state == state; });
  }
  bool takes(int frames) {
    const int end = taken_ + frames;
    return until([&] { return taken_ >= end; });
  }
  const hal::CameraStats& stats() const { return camera_->stats(); }

  hal::MonotonicClock clock_;
  V4l2CameraConfig config_;
  std::optional<V4l2Camera> camera_;
  hal::GrayImage image_;
  int taken_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint32_t driver_sequence_ = 0;
  Time exposure_{};
};

/// How many of this process's descriptors, or mappings, belong to the device.
int held(const std::string& device) {
  int count = 0;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd", ignored))
    count += fs::read_symlink(entry.path(), ignored) == device;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) count += line.ends_with(device);
  return count;
}

double correlation(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  const auto n = static_cast<double>(a.size());
  double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a[i], y = b[i];
    sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
  }
  return (sab - sa * sb / n) / std::sqrt((saa - sa * sa / n) * (sbb - sb * sb / n));
}

TEST_F(VividCamera, SeesWhatV4l2CtlSees) {
  set("osd_text_mode", 2);  // no running numbers in the picture
  const fs::path file = fs::temp_directory_path() / "vivid_frame";
  ASSERT_EQ(
      run(fmt::format("v4l2-ctl -d {} --set-fmt-video width=320,height=180,pixelformat=YUYV --stream-mmap "
                      "--stream-count=1 --stream-to={} >/dev/null 2>&1",
                      config_.path, file.string())),
      0);
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> yuyv{std::istreambuf_iterator<char>(in), {}};
  ASSERT_EQ(yuyv.size(), 320u * 180 * 2);
  open();
  ASSERT_TRUE(takes(3));
  ASSERT_EQ(image_.pixels.size(), 320u * 180);
  for (std::size_t i = 0; i < image_.pixels.size(); ++i)
    ASSERT_EQ(image_.pixels[i], static_cast<std::uint8_t>(yuyv[2 * i])) << i;
}

TEST_F(VividCamera, ShowsTheSameInEveryFormat) {
  set("osd_text_mode", 2);
  set("test_pattern", 20);  // a ramp of grey: of colours vivid makes other greys in GREY than in YUYV
  std::vector<std::uint8_t> first;
  for (const PixelFormat format :
       {PixelFormat::kYuyv, PixelFormat::kGrey, PixelFormat::kY16, PixelFormat::kNv12}) {
    config_.format = format;
    camera_.reset();
    sequence_ = 0;
    open();
    ASSERT_TRUE(takes(3)) << code_text(code_of(format));
    if (first.empty()) first = image_.pixels;
    ASSERT_EQ(image_.pixels.size(), first.size());
    // Some formats use all values and some leave out the darkest and the brightest.
    EXPECT_GT(correlation(first, image_.pixels), 0.99) << code_text(code_of(format));
  }
}

TEST_F(VividCamera, CountsEveryFrameOfTheDriver) {
  open();
  ASSERT_TRUE(takes(50));
  EXPECT_EQ(stats().state, CameraState::kStreaming);
  EXPECT_EQ(stats().damaged + stats().frozen + stats().wrong_clock, 0u);
  EXPECT_EQ(stats().gone, 0u);
}

TEST_F(VividCamera, IsListedWithWhatItOffers) {
  const std::vector<ListedCamera> cameras = list_cameras(kernel_calls(), "/dev");
  const auto ours =
      std::find_if(cameras.begin(), cameras.end(), [&](const auto& c) { return c.path == config_.path; });
  ASSERT_NE(ours, cameras.end());
  EXPECT_EQ(ours->name, "vivid");
  EXPECT_THAT(one_line(offered_formats(kernel_calls(), config_.path.c_str())),
              AllOf(HasSubstr("YUYV 640 x 480 ("), HasSubstr("GREY 640 x 480 ("),
                    HasSubstr("that Headway does not read: ")));
}

TEST_F(VividCamera, SaysWhatItOffersWhenItDoesNotHaveAFormat) {
  config_.format = PixelFormat::kMjpeg;
  EXPECT_THAT(refusal(), AllOf(HasSubstr("asked for 320 x 180 px of MJPG"), HasSubstr("it offers"),
                               HasSubstr("YUYV 640 x 480")));
  EXPECT_EQ(held(config_.path), 0);
}

TEST_F(VividCamera, RefusesARateThatIsSilentlyChanged) {
  config_.width = 640;
  config_.height = 480;
  config_.rate = 30;
  EXPECT_THAT(refusal(), HasSubstr("asked for 30 frames/s, and gives 25"));
  config_.rate = 25;
  EXPECT_EQ(refusal(), "");
  EXPECT_EQ(camera_->period(), seconds(0.04));
}

TEST_F(VividCamera, SetsGainAndTurnsItsAutomaticOff) {
  config_.gain = 77;
  ASSERT_EQ(refusal(), "");
  EXPECT_EQ(run(fmt::format("v4l2-ctl -d {} -C gain | grep -qx 'gain: 77'", config_.path)), 0);
  EXPECT_EQ(run(fmt::format("v4l2-ctl -d {} -C gain_automatic | grep -qx 'gain_automatic: 0'", config_.path)),
            0);
  EXPECT_TRUE(takes(3));
}

TEST_F(VividCamera, SaysThatItHasNoExposureToSet) {
  config_.exposure = std::chrono::milliseconds(8);
  EXPECT_THAT(refusal(), HasSubstr("no control for exposure"));
}

TEST_F(VividCamera, SaysThatAnotherProgramUsesIt) {
  open();
  ASSERT_TRUE(takes(1));
  EXPECT_THROW(V4l2Camera(config_, clock_), Error);
  try {
    V4l2Camera second(config_, clock_);
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("used by another program"));
  }
  EXPECT_TRUE(takes(3));
}

TEST_F(VividCamera, LeavesOutAFrameThatIsMarkedAndGoesOn) {
  open();
  ASSERT_TRUE(takes(3));
  set("inject_v4l2_buf_flag_error", 1);
  EXPECT_TRUE(until([&] { return stats().damaged == 1; }));
  EXPECT_TRUE(takes(5));
  EXPECT_EQ(stats().damaged, 1u);
  EXPECT_EQ(stats().gone, 0u);
}

TEST_F(VividCamera, GoesOnWhenTheDriversCountRunsOver) {
  set("wrap_sequence_number", 1);
  open();
  // vivid begins 128 frames before the end.
  bool was_high = false;
  ASSERT_TRUE(until([&] {
    was_high = was_high || driver_sequence_ > UINT32_MAX - 128;
    return was_high && driver_sequence_ > 0 && driver_sequence_ < 128;
  }));
  EXPECT_LT(stats().lost, 10000u);
}

TEST_F(VividCamera, TakesNoFrameWithStampsOfAnotherTime) {
  set("wrap_timestamp", 1);
  open();
  EXPECT_TRUE(until([&] { return stats().wrong_clock >= 5; }));
  EXPECT_EQ(taken_, 0);
  EXPECT_TRUE(until_state(CameraState::kWrongClock));
  set("wrap_timestamp", 0);
  EXPECT_TRUE(until_state(CameraState::kStreaming));
}

TEST_F(VividCamera, CountsFramesThatWereDropped) {
  open();
  ASSERT_TRUE(takes(3));
  set("percentage_of_dropped_buffers", 30);
  EXPECT_TRUE(until([&] { return stats().lost >= 10; }));
  set("percentage_of_dropped_buffers", 0);
  EXPECT_TRUE(takes(10));
  EXPECT_EQ(stats().state, CameraState::kStreaming);
}

TEST_F(VividCamera, RestartsAndOpensAgainWhatSendsNothingAndStreamsWhenThatEnds) {
  open();
  ASSERT_TRUE(takes(3));
  set("percentage_of_dropped_buffers", 100);
  EXPECT_TRUE(until_state(CameraState::kSilent));
  EXPECT_TRUE(until([&] { return stats().gone == 1; }));
  EXPECT_EQ(stats().restarts, 2u);
  EXPECT_EQ(held(config_.path), 0);
  set("percentage_of_dropped_buffers", 0);
  EXPECT_TRUE(until_state(CameraState::kStreaming));
  EXPECT_TRUE(takes(5));
}

TEST_F(VividCamera, ComesBackWhenABufferIsRefused) {
  open();
  ASSERT_TRUE(takes(3));
  set("inject_vidioc_qbuf_error", 1);
  EXPECT_TRUE(until([&] { return stats().gone == 1; }));
  EXPECT_TRUE(until_state(CameraState::kStreaming));
  EXPECT_TRUE(takes(5));
}

TEST_F(VividCamera, ComesBackFromAFatalErrorOfTheStream) {
  open();
  ASSERT_TRUE(takes(3));
  set("inject_fatal_streaming_error", 1);
  EXPECT_TRUE(until_state(CameraState::kGone));
  EXPECT_EQ(held(config_.path), 0);
  EXPECT_TRUE(until_state(CameraState::kStreaming));
  EXPECT_TRUE(takes(5));
}

TEST_F(VividCamera, SaysWhyItCannotStartAndLeavesNothingOpen) {
  for (const char* fault : {"inject_vidioc_reqbufs_error", "inject_vidioc_streamon_error"}) {
    set(fault, 1);
    EXPECT_THAT(refusal(), HasSubstr("Invalid argument")) << fault;
    EXPECT_EQ(held(config_.path), 0);
    EXPECT_EQ(refusal(), "") << "the fault is over";
    sequence_ = 0;
    EXPECT_TRUE(takes(3));
    camera_.reset();
  }
}

TEST_F(VividCamera, LetsGoOfACameraThatIsUnpluggedAndTakesItBack) {
  open();
  ASSERT_TRUE(takes(3));
  set("disconnect", 1);
  EXPECT_TRUE(until_state(CameraState::kGone));
  EXPECT_THAT(camera_->fault(), HasSubstr("unplugged"));
  EXPECT_EQ(held(config_.path), 0);
  // The kernel unloads no driver whose device is still open.
  ASSERT_EQ(run("rmmod vivid"), 0);
  clock_.sleep_until(clock_.now() + seconds(2));
  camera_->poll();
  EXPECT_THAT(camera_->fault(), HasSubstr("is it plugged in"));
  ASSERT_EQ(run("modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0x0"), 0);
  // Until then its stamps may lie in the future, and none of its frames is taken.
  ASSERT_TRUE(until([&] { return fs::exists(config_.path); }));
  set("timestamp_source", 1);
  EXPECT_TRUE(until_state(CameraState::kStreaming));
  EXPECT_TRUE(takes(5));
}

TEST_F(VividCamera, HoldsNothingAfterAHundredTimes) {
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(refusal(), "");
    ASSERT_GT(held(config_.path), 4);
    camera_->poll();
    camera_.reset();
    ASSERT_EQ(held(config_.path), 0);
  }
}

TEST_F(VividCamera, HoldsNothingMoreAfterFiftyUnplugs) {
  config_.retry = {.first = std::chrono::milliseconds(10), .longest = std::chrono::milliseconds(10)};
  const Held while_closed = held_now();
  open();
  const Held while_open = held_now();
  EXPECT_GT(while_open.camera_buffers, while_closed.camera_buffers);
  for (std::uint64_t i = 0; i < 50; ++i) {
    // While udev still looks at the old device file, the next one gets another name.
    ASSERT_EQ(run("udevadm settle && echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind"), 0);
    ASSERT_TRUE(until([&] { return stats().gone == i + 1; })) << i;
    ASSERT_EQ(held_now(), while_closed) << i;
    ASSERT_EQ(run("udevadm settle && echo vivid.0 >/sys/bus/platform/drivers/vivid/bind"), 0);
    // Open, whatever its stamps are worth: they may lie in the future.
    ASSERT_TRUE(until([&] { return held(config_.path) > 4; })) << i;
    ASSERT_EQ(held_now(), while_open) << i;
  }
  set("timestamp_source", 1);
  EXPECT_TRUE(until_state(CameraState::kStreaming));
}

TEST_F(VividCamera, NeverTakesAFrameFromTheFuture) {
  // With this source vivid stamps the end of a frame that it has not yet waited for.
  set("timestamp_source", 0);
  open();
  EXPECT_TRUE(until([&] { return stats().wrong_clock + stats().usable >= 50; }));
}

}  // namespace
}  // namespace headway::drivers
