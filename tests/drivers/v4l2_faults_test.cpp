// What a camera's driver does when the camera goes wrong: every fault alone, then many in any order.
#include <algorithm>
#include <cerrno>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <rapidcheck/gtest.h>

#include "tests/drivers/camera_bench.h"

namespace headway::drivers {
namespace {

using hal::CameraState;
using testing::Call, testing::CameraBench, testing::ScriptedCamera;
using ::testing::HasSubstr;

/// Longer than two restarts, the longest back-off and the first frame after it.
constexpr Duration kMended = std::chrono::seconds(15);

/// Bench that streams.
class V4l2Faults : public ::testing::Test {
 protected:
  V4l2Faults() { bench_.start(); }
  ~V4l2Faults() override {
    EXPECT_TRUE(bench_.calls.violations.empty()) << bench_.calls.violations.front();
    bench_.camera.reset();
    EXPECT_EQ(bench_.calls.open_descriptors(), 0u);
    EXPECT_EQ(bench_.calls.mappings(), 0u);
  }
  bool becomes(CameraState state, Duration limit) { return bench_.run_until(state, limit); }
  const hal::CameraStats& stats() { return bench_.stats(); }

  CameraBench bench_;
  ScriptedCamera& device_ = *bench_.device;
};

TEST_F(V4l2Faults, LeavesOutAFrameThatTheDriverMarks) {
  const int before = bench_.taken;
  device_.marked = true;
  bench_.run(seconds(0.07));
  device_.marked = false;
  EXPECT_EQ(bench_.taken, before);
  EXPECT_EQ(stats().damaged, 2u);
  bench_.run(seconds(0.1));
  EXPECT_EQ(bench_.taken, before + 3);
  EXPECT_EQ(stats().state, CameraState::kStreaming);
  EXPECT_EQ(stats().restarts, 0u);
}

TEST_F(V4l2Faults, LeavesOutHalfAFrame) {
  device_.half = true;
  bench_.run(seconds(0.07));
  EXPECT_EQ(stats().damaged, 2u);
  EXPECT_TRUE(becomes(CameraState::kDamaged, seconds(0.2)));
  device_.half = false;
  EXPECT_TRUE(becomes(CameraState::kStreaming, kMended));
}

TEST_F(V4l2Faults, ReadsNoFurtherThanTheBufferWhateverTheDriverSays) {
  const int before = bench_.taken;
  device_.extra_bytes = 1 << 30;
  bench_.run(seconds(0.2));
  EXPECT_GT(bench_.taken, before);
}

TEST_F(V4l2Faults, CallsARepeatedStampFrozen) {
  device_.frozen = true;
  EXPECT_TRUE(becomes(CameraState::kFrozen, seconds(0.3)));
  EXPECT_GT(stats().frozen, 2u);
  bench_.run(seconds(20));
  EXPECT_EQ(stats().state, CameraState::kFrozen);
  EXPECT_GT(stats().restarts, 2u);
  EXPECT_GT(stats().gone, 1u);
  EXPECT_THAT(bench_.camera->fault(), HasSubstr("no usable frames"));
  device_.frozen = false;
  EXPECT_TRUE(becomes(CameraState::kStreaming, kMended));
}

TEST_F(V4l2Faults, CallsStampsOfAnotherClockSo) {
  for (const Duration shift : {seconds(0.05), seconds(-3), seconds(1.7e9)}) {
    const int before = bench_.taken;
    device_.stamp_shift = shift;
    EXPECT_TRUE(becomes(CameraState::kWrongClock, seconds(0.3))) << to_seconds(shift);
    EXPECT_LE(bench_.taken, before + 1);
    device_.stamp_shift = {};
    EXPECT_TRUE(becomes(CameraState::kStreaming, kMended)) << to_seconds(shift);
  }
  device_.foreign_clock = true;
  EXPECT_TRUE(becomes(CameraState::kWrongClock, seconds(0.3)));
}

TEST_F(V4l2Faults, RestartsASilentStreamAfterThreePeriodsAndThatMayHelp) {
  device_.silent = true;
  bench_.run(seconds(0.09));
  EXPECT_EQ(stats().state, CameraState::kStreaming);
  EXPECT_TRUE(becomes(CameraState::kSilent, seconds(0.05)));
  EXPECT_EQ(stats().restarts, 1u);
  EXPECT_EQ(device_.starts, 2);
  device_.silent = false;
  EXPECT_TRUE(becomes(CameraState::kStreaming, seconds(1)));
  EXPECT_EQ(stats().restarts, 1u);
  EXPECT_EQ(stats().gone, 0u);
}

TEST_F(V4l2Faults, OpensASilentCameraAgainAfterTwoRestartsInVain) {
  device_.silent = true;
  EXPECT_TRUE(bench_.run_until([&] { return stats().gone == 1; }, seconds(5)));
  EXPECT_EQ(stats().restarts, 2u);
  EXPECT_EQ(stats().state, CameraState::kSilent);
  EXPECT_EQ(bench_.calls.open_descriptors(), 0u);
  device_.silent = false;
  EXPECT_TRUE(becomes(CameraState::kStreaming, seconds(2)));
}

TEST_F(V4l2Faults, GivesACameraTimeForItsFirstFrame) {
  device_.unplug();
  bench_.run(seconds(0.1));
  device_.start_up = seconds(1.8);
  device_.plug();
  EXPECT_TRUE(becomes(CameraState::kStreaming, seconds(4)));
  EXPECT_EQ(stats().restarts, 0u);
}

TEST_F(V4l2Faults, TearsDownAtOnceWhenUnpluggedAndOpensAgainWithGrowingPauses) {
  bench_.run(seconds(0.5));
  device_.unplug();
  bench_.step();
  EXPECT_EQ(stats().state, CameraState::kGone);
  EXPECT_EQ(bench_.calls.open_descriptors(), 0u);
  EXPECT_EQ(bench_.calls.mappings(), 0u);
  EXPECT_THAT(bench_.camera->fault(), HasSubstr("unplugged"));
  std::vector<Duration::rep> tries;  // [ms] after the unplug
  const Time unplugged = bench_.clock.now();
  for (std::uint64_t calls = bench_.calls.calls; bench_.clock.now() < unplugged + seconds(25);) {
    bench_.step(std::chrono::milliseconds(10));
    if (std::exchange(calls, bench_.calls.calls) != bench_.calls.calls)
      tries.push_back((bench_.clock.now() - unplugged) / std::chrono::milliseconds(1));
  }
  EXPECT_THAT(tries, ::testing::ElementsAre(500, 1500, 3500, 7500, 12500, 17500, 22500));
  device_.plug();
  EXPECT_TRUE(becomes(CameraState::kStreaming, seconds(6)));
  EXPECT_EQ(stats().gone, 1u);
}

TEST_F(V4l2Faults, ComesBackFromAnyErrorOfAnyCall) {
  for (const int error : {EIO, ENODEV, EINVAL, ENOSPC}) {
    for (int call = 0; call < testing::kCalls; ++call) {
      const bool is_poll = Call(call) == Call::kPoll;
      // Calls that are made only while it is opened or restarted have to be brought about.
      device_.silent = true;
      bench_.run_until([&] { return !device_.is_streaming; }, seconds(10));
      device_.silent = false;
      device_.fails_once[Call(call)] = is_poll ? POLLERR : error;
      ASSERT_TRUE(
          bench_.run_until([&] { return device_.fails_once.empty() || Call(call) == Call::kStop; }, kMended))
          << call;
      ASSERT_TRUE(becomes(CameraState::kStreaming, kMended)) << call << " " << error;
      device_.fails_once.clear();
    }
  }
}

TEST_F(V4l2Faults, CallsAStreamThatFailsGone) {
  for (const auto& [call, error] : std::vector<std::pair<Call, int>>{{Call::kDequeue, EIO},
                                                                     {Call::kDequeue, ENODEV},
                                                                     {Call::kQueue, EIO},
                                                                     {Call::kQueue, EINVAL},
                                                                     {Call::kPoll, POLLERR},
                                                                     {Call::kPoll, POLLHUP}}) {
    const std::uint64_t before = stats().gone;
    device_.fails_once[call] = error;
    EXPECT_TRUE(becomes(CameraState::kGone, seconds(0.1)));
    EXPECT_EQ(stats().gone, before + 1);
    EXPECT_TRUE(becomes(CameraState::kStreaming, seconds(2)));
  }
}

TEST_F(V4l2Faults, HasAWholeFrameThoughTheCameraGoesWhenItIsGivenBack) {
  bench_.run(seconds(0.1));
  const int before = bench_.taken;
  device_.fails_once[Call::kQueue] = ENODEV;
  EXPECT_TRUE(becomes(CameraState::kGone, seconds(0.1)));
  EXPECT_EQ(bench_.taken, before + 1);
  EXPECT_EQ(bench_.image.pixels, std::vector<std::uint8_t>(32 * 24, static_cast<std::uint8_t>(device_.made)));
}

TEST_F(V4l2Faults, KeepsNoFrameOfACameraThatGoesWhileOneIsPassedOver) {
  bench_.camera->poll();
  device_.fails_once[Call::kQueue] = ENODEV;
  bench_.clock.advance(seconds(0.12));  // three frames: the first is given back
  bench_.camera->poll();
  EXPECT_EQ(stats().state, CameraState::kGone);
  EXPECT_TRUE(bench_.camera->waiting().empty());
  EXPECT_TRUE(becomes(CameraState::kStreaming, kMended));
}

TEST_F(V4l2Faults, SaysThatACameraCameBackWithAnotherFormat) {
  device_.unplug();
  bench_.run(seconds(0.1));
  std::swap(device_.offers[0].width, device_.offers[0].height);
  device_.plug();
  EXPECT_TRUE(becomes(CameraState::kWrongFormat, seconds(2)));
  EXPECT_THAT(bench_.camera->fault(), HasSubstr("gives 24 x 32 px"));
  EXPECT_EQ(bench_.calls.open_descriptors(), 0u);
  std::swap(device_.offers[0].width, device_.offers[0].height);
  EXPECT_TRUE(becomes(CameraState::kStreaming, kMended));
}

TEST(V4l2FaultsOfACamera, ThatComesBackWithShorterLinesAreNone) {
  CameraBench bench;
  bench.device->padding = 16;
  bench.start();
  bench.device->unplug();
  bench.run(seconds(0.1));
  bench.device->padding = 0;
  bench.device->plug();
  EXPECT_TRUE(bench.run_until(CameraState::kStreaming, kMended));
  bench.run(seconds(0.5));
  EXPECT_EQ(bench.stats().damaged, 0u);
}

TEST_F(V4l2Faults, SaysThatACameraCameBackAndRefusesItsSettings) {
  device_.unplug();
  bench_.run(seconds(0.1));
  device_.controls.at(V4L2_CID_EXPOSURE_ABSOLUTE).value = 100;
  device_.deaf_to = {V4L2_CID_EXPOSURE_ABSOLUTE};
  device_.plug();
  EXPECT_TRUE(becomes(CameraState::kWrongFormat, seconds(2)));
  EXPECT_THAT(bench_.camera->fault(), HasSubstr("exposure"));
  device_.deaf_to.clear();
  EXPECT_TRUE(becomes(CameraState::kStreaming, kMended));
}

TEST_F(V4l2Faults, DoesNotCallFramesLostThatCameWhileItWasStarted) {
  for (const bool is_unplugged : {false, true}) {
    if (is_unplugged) device_.unplug();
    device_.silent = true;
    bench_.run(seconds(0.2));
    device_.mend();
    device_.lose = 10;
    bench_.run_until([&] { return device_.lose == 0; }, seconds(5));
    ASSERT_TRUE(becomes(CameraState::kStreaming, kMended));
    EXPECT_EQ(stats().lost, 0u);
  }
}

TEST_F(V4l2Faults, SequenceNumbersOnlyGrowWhateverHappens) {
  std::uint64_t last = 0;
  Time exposure{};
  bench_.on_frame = [&](const V4l2Camera::Waiting& frame) {
    EXPECT_GT(frame.sequence, last);
    EXPECT_GT(frame.exposure, exposure);
    last = frame.sequence;
    exposure = frame.exposure;
  };
  for (int i = 0; i < 5; ++i) {
    bench_.run(seconds(0.5));
    device_.unplug();
    bench_.run(seconds(0.1));
    device_.plug();
    bench_.run(seconds(1.5));
    device_.count_anew = true;
    bench_.run(seconds(0.1));
    device_.silent = true;
    bench_.run(seconds(0.2));
    device_.silent = false;
  }
  EXPECT_GT(last, 100u);
}

TEST_F(V4l2Faults, LeakNothingInTenThousandUnplugs) {
  bench_.config.first_frame = seconds(0.5);
  for (int i = 0; i < 10000; ++i) {
    if (i % 4 == 0) {
      device_.fails.clear();
      device_.unplug_in = 0;
      device_.plug();
      bench_.open();
    }
    // At any call from opening to well into the stream.
    device_.unplug_in = 1 + static_cast<std::uint64_t>(i) % 61;
    for (int k = 0; k < 40 && device_.plugged; ++k) bench_.step(std::chrono::milliseconds(40));
    device_.unplug();
    bench_.step();
    ASSERT_EQ(bench_.calls.open_descriptors(), 0u) << i;
    ASSERT_EQ(bench_.calls.mappings(), 0u) << i;
    device_.plug();
  }
  EXPECT_GT(device_.generation, 9000u);
}

/// Something that goes wrong with a camera for a while.
struct Trouble {
  int kind = 0;
  int call = 0, error = 0;
  int milliseconds = 0;
};

void showValue(const Trouble& t, std::ostream& os) {
  os << "kind " << t.kind << " call " << t.call << " error " << t.error << " for " << t.milliseconds << " ms";
}

constexpr int kTroubles = 16;

void begin(const Trouble& trouble, ScriptedCamera& device) {
  const Call call{static_cast<std::uint8_t>(trouble.call)};
  const int polled = trouble.error == EIO ? POLLERR : POLLERR | POLLHUP;
  const int error = call == Call::kPoll ? polled : trouble.error;
  switch (trouble.kind) {
    case 0:
      device.unplug();
      break;
    case 1:
      device.plug();
      break;
    case 2:
      device.silent = true;
      break;
    case 3:
      device.frozen = true;
      break;
    case 4:
      device.marked = true;
      break;
    case 5:
      device.half = true;
      break;
    case 6:
      device.foreign_clock = true;
      break;
    case 7:
      device.stamp_shift = std::chrono::milliseconds(trouble.milliseconds - 1000);
      break;
    case 8:
      device.interlaced = true;
      break;
    case 9:
      device.fails[call] = error;
      break;
    case 10:
      device.fails_once[call] = error;
      break;
    case 11:
      device.lose = static_cast<std::uint32_t>(trouble.milliseconds) % 20;
      break;
    case 12:
      device.count_anew = true;
      break;
    case 13:
      device.unplug_in = 1 + static_cast<std::uint64_t>(trouble.milliseconds) % 40;
      break;
    case 14:
      device.deaf_to = {V4L2_CID_EXPOSURE_ABSOLUTE};
      break;
    case 15:
      device.extra_bytes = static_cast<std::size_t>(trouble.milliseconds);
      break;
    default:
      device.mend();
  }
}

rc::Gen<Trouble> any_trouble() {
  return rc::gen::build<Trouble>(
      rc::gen::set(&Trouble::kind, rc::gen::inRange(0, kTroubles + 1)),
      rc::gen::set(&Trouble::call, rc::gen::inRange(0, testing::kCalls)),
      rc::gen::set(&Trouble::error, rc::gen::element(EIO, ENODEV, EINVAL, EBUSY, ENOSPC)),
      rc::gen::set(&Trouble::milliseconds, rc::gen::inRange(1, 4000)));
}

RC_GTEST_PROP(V4l2Camera, StreamsAgainAfterAnyTroublesAndMisusesNothing, ()) {
  CameraBench bench;
  bench.start();
  for (const Trouble& trouble : *rc::gen::container<std::vector<Trouble>>(any_trouble())) {
    begin(trouble, *bench.device);
    // Now often enough, now so late that more frames come than may wait.
    const auto cycle = std::chrono::milliseconds(1 + trouble.milliseconds % 150);
    bench.run(std::chrono::milliseconds(trouble.milliseconds), cycle);
    RC_ASSERT(bench.calls.open_descriptors() <= 1);
    RC_ASSERT(bench.calls.mappings() <= 4);
  }
  bench.device->mend();
  RC_ASSERT(bench.run_until(CameraState::kStreaming, kMended));
  const int before = bench.taken;
  bench.run(seconds(1));
  // It may go down once more if what spoilt it is still in the driver's queue.
  RC_ASSERT(bench.taken > before);
  const std::uint8_t first = bench.image.pixels.front();
  RC_ASSERT(std::count(bench.image.pixels.begin(), bench.image.pixels.end(), first) == 32 * 24);
  RC_ASSERT(bench.calls.open_descriptors() == 1);
  RC_ASSERT(bench.calls.mappings() == 4);
  bench.camera.reset();
  RC_ASSERT(bench.calls.open_descriptors() == 0);
  RC_ASSERT(bench.calls.mappings() == 0);
  RC_ASSERT(bench.calls.violations.empty());
}

}  // namespace
}  // namespace headway::drivers
