// Two eyes as one camera: which frames are a pair, and what becomes of it when an eye fails.
#include "drivers/stereo_pair.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <numeric>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/drivers/camera_bench.h"

namespace headway::drivers {
namespace {

using hal::CameraState;
using testing::ScriptedCamera;

constexpr const char* kRight = "/dev/v4l/by-path/right";
constexpr Duration kMended = std::chrono::seconds(15);

class PairBench {
 public:
  explicit PairBench(PixelFormat format = PixelFormat::kGrey) {
    clock.set(at_seconds(100));
    config.left = config.right = testing::small_config(format);
    config.right.path = kRight;
    left = &calls.add(testing::kEye, ScriptedCamera(format));
    right = &calls.add(kRight, ScriptedCamera(format));
    // A frame's number is what it shows.
    left->paint = right->paint = [](std::span<std::uint8_t> buffer, std::uint32_t number) {
      std::fill(buffer.begin(), buffer.end(), static_cast<std::uint8_t>(number % 200));
      buffer.back() = static_cast<std::uint8_t>(number / 200);
      return buffer.size();
    };
  }

  hal::ManualClock clock;
  testing::ScriptedCalls calls{clock};
  ScriptedCamera *left, *right;
  StereoPairConfig config;
  std::optional<StereoPair> pair;
  hal::StereoFrame frame;
  int taken = 0;

  /// The right eye's frames come `offset` after the left's.
  void open(Duration offset = {}) {
    right->start_up = left->start_up + offset;
    pair.emplace(config, clock, calls);
  }
  bool step(Duration d = std::chrono::milliseconds(5)) {
    clock.advance(d);
    const bool is_new = pair->take_newest(frame);
    taken += is_new;
    return is_new;
  }
  void run(Duration d, Duration cycle = std::chrono::milliseconds(5)) {
    for (const Time end = clock.now() + d; clock.now() < end;) step(cycle);
  }
  bool run_until(CameraState state, Duration limit) {
    for (const Time end = clock.now() + limit; clock.now() < end && pair->state() != state;) step();
    return pair->state() == state;
  }
  std::uint64_t recorded() const {
    const auto& bins = pair->stats().differences;
    return std::accumulate(bins.begin(), bins.end(), std::uint64_t{0});
  }
};

TEST(StereoPair, HandsOutFramesThatWereExposedTogether) {
  PairBench bench;
  bench.open(std::chrono::milliseconds(3));
  EXPECT_EQ(bench.pair->state(), CameraState::kStarting);
  std::uint64_t last = 0;
  for (int i = 0; i < 400; ++i) {
    if (!bench.step()) continue;
    EXPECT_EQ(bench.frame.sequence, last + 1);
    last = bench.frame.sequence;
    EXPECT_EQ(bench.frame.left.pixels.front(), last % 200);
    EXPECT_EQ(bench.frame.right.pixels, bench.frame.left.pixels);
  }
  EXPECT_EQ(bench.pair->state(), CameraState::kStreaming);
  EXPECT_EQ(bench.pair->stats().pairs, last);
  EXPECT_EQ(bench.pair->stats().unpaired, 0u);
  EXPECT_EQ(bench.pair->stats().differences[11 + 6], last);  // 3.0 to 3.5 ms
  EXPECT_NEAR(bench.pair->rate(bench.clock.now()), 30, 1);
}

TEST(StereoPair, SaysTheMiddleOfBothExposures) {
  PairBench bench;
  bench.open(std::chrono::milliseconds(-4));
  bench.run(seconds(0.4));
  ASSERT_GT(bench.taken, 0);
  bench.right->silent = true;
  const Time left = bench.pair->left().waiting().empty() ? bench.left->middles.back() : Time{};
  EXPECT_LE(std::chrono::abs(bench.frame.exposure - (left - std::chrono::milliseconds(2))),
            std::chrono::microseconds(2));
}

TEST(StereoPair, TakesTheNewestPairWhenItIsLate) {
  PairBench bench;
  bench.open();
  bench.run(seconds(1));
  ASSERT_TRUE(bench.step(seconds(0.1)));
  EXPECT_EQ(bench.frame.sequence, bench.left->made);
  EXPECT_FALSE(bench.step(std::chrono::milliseconds(1)));
}

TEST(StereoPair, WaitsForTheEyeThatIsLater) {
  PairBench bench;
  bench.open(std::chrono::milliseconds(4));
  bench.clock.advance(seconds(0.302));
  EXPECT_FALSE(bench.pair->take_newest(bench.frame));
  bench.clock.advance(seconds(0.003));
  EXPECT_TRUE(bench.pair->take_newest(bench.frame));
}

TEST(StereoPair, CallsEyesThatAreTooFarApartOutOfStep) {
  PairBench bench;
  bench.open(std::chrono::milliseconds(12));
  EXPECT_TRUE(bench.run_until(CameraState::kUnpaired, seconds(1)));
  bench.run(seconds(1));
  EXPECT_EQ(bench.taken, 0);
  EXPECT_EQ(bench.pair->stats().pairs, 0u);
  EXPECT_GT(bench.pair->stats().unpaired, 50u);
  EXPECT_EQ(bench.pair->rate(bench.clock.now()), 0);
  // The left eye's frames are 12 ms early; all beyond 5 ms share one bin.
  EXPECT_GT(bench.pair->stats().differences.back(), 20u);
}

TEST(StereoPair, LeavesOutAFrameThatOneEyeLost) {
  PairBench bench;
  bench.open();
  bench.run(seconds(1));
  const auto pairs = bench.pair->stats().pairs;
  bench.right->lose = 1;
  bench.run(seconds(0.5));
  EXPECT_EQ(bench.pair->stats().unpaired, 1u);
  EXPECT_EQ(bench.pair->right().stats().lost, 1u);
  EXPECT_EQ(bench.pair->stats().pairs, pairs + 14);
  EXPECT_EQ(bench.frame.left.pixels, bench.frame.right.pixels);
}

TEST(StereoPair, NamesWhatIsTheMatterWithAnEyeAndGoesOnWhenItIsMended) {
  PairBench bench;
  bench.open();
  bench.run(seconds(0.5));
  for (ScriptedCamera* eye : {bench.left, bench.right}) {
    eye->frozen = true;
    EXPECT_TRUE(bench.run_until(CameraState::kFrozen, seconds(0.5)));
    eye->frozen = false;
    EXPECT_TRUE(bench.run_until(CameraState::kStreaming, kMended));
    eye->unplug();
    EXPECT_TRUE(bench.run_until(CameraState::kGone, seconds(0.1)));
    const int before = bench.taken;
    bench.run(seconds(1));
    EXPECT_EQ(bench.taken, before);
    eye->plug();
    EXPECT_TRUE(bench.run_until(CameraState::kStreaming, kMended));
    eye->silent = true;
    EXPECT_TRUE(bench.run_until(CameraState::kSilent, seconds(0.5)));
    eye->silent = false;
    EXPECT_TRUE(bench.run_until(CameraState::kStreaming, kMended));
  }
  EXPECT_TRUE(bench.calls.violations.empty());
}

TEST(StereoPair, LeavesTheCallersFrameAloneWhenOneImageIsBroken) {
  PairBench bench(PixelFormat::kMjpeg);
  bool is_broken = false;
  const auto paint = [&is_broken](bool breaks) {
    return [&is_broken, breaks](std::span<std::uint8_t> buffer, std::uint32_t number) {
      std::vector<std::uint8_t> data;
      cv::imencode(".jpg", cv::Mat(24, 32, CV_8UC1, cv::Scalar(number % 200)), data);
      if (breaks && is_broken) data.resize(data.size() - 20);
      std::copy(data.begin(), data.end(), buffer.begin());
      return data.size();
    };
  };
  bench.left->paint = paint(false);
  bench.right->paint = paint(true);
  bench.open();
  bench.run(seconds(0.5));
  ASSERT_GT(bench.taken, 1);
  const hal::StereoFrame before = bench.frame;
  is_broken = true;
  bench.run(seconds(0.04));
  EXPECT_EQ(bench.frame.sequence, before.sequence);
  EXPECT_EQ(bench.frame.left.pixels, before.left.pixels);
  bench.run(seconds(0.2));
  EXPECT_EQ(bench.pair->state(), CameraState::kDamaged);
  is_broken = false;
  bench.run(seconds(0.2));
  EXPECT_EQ(bench.pair->state(), CameraState::kStreaming);
  EXPECT_GT(bench.frame.sequence, before.sequence);
}

TEST(StereoPair, RefusesEyesThatCannotBeAPair) {
  const auto refuses = [](auto spoil) {
    PairBench bench;
    spoil(bench.config);
    try {
      bench.open();
    } catch (const InputError&) {
      return bench.calls.calls == 0;
    }
    return false;
  };
  EXPECT_TRUE(refuses([](StereoPairConfig& c) { c.right.path = c.left.path; }));
  EXPECT_TRUE(refuses([](StereoPairConfig& c) { c.right.width = 64; }));
  EXPECT_TRUE(refuses([](StereoPairConfig& c) { c.right.rate = 15; }));
  EXPECT_TRUE(refuses([](StereoPairConfig& c) { c.right.exposure.reset(); }));
  EXPECT_TRUE(refuses([](StereoPairConfig& c) { c.left.gain = 3; }));
  EXPECT_TRUE(refuses([](StereoPairConfig& c) { c.left.format = PixelFormat::kZ16; }));
  EXPECT_TRUE(refuses([](StereoPairConfig& c) { c.tolerance = Duration::zero(); }));
}

TEST(StereoPair, ClosesTheLeftEyeWhenTheRightIsNotThere) {
  PairBench bench;
  bench.right->unplug();
  EXPECT_THROW(bench.open(), InputError);
  EXPECT_EQ(bench.calls.open_descriptors(), 0u);
  EXPECT_EQ(bench.calls.mappings(), 0u);
}

// Each picture shows its number, and the scripted camera remembers when that frame was exposed.
RC_GTEST_PROP(StereoPair, PairsAreNearEnoughInOrderAndCountedWhateverIsLost, ()) {
  PairBench bench;
  const Duration offset = std::chrono::microseconds(*rc::gen::inRange(-16000, 16000));
  bench.open(offset);
  const auto exposure_of = [](const ScriptedCamera& eye, const hal::GrayImage& image) {
    return eye.middles.at(image.pixels.front() + 200u * image.pixels.back() - 1);
  };
  std::uint64_t last = 0;
  while (bench.left->made < 150) {
    for (ScriptedCamera* eye : {bench.left, bench.right}) {
      eye->lose = *rc::gen::weightedElement<std::uint32_t>({{8, 0}, {2, 1}});
      eye->marked = *rc::gen::weightedElement<bool>({{9, false}, {1, true}});
    }
    if (!bench.step(std::chrono::milliseconds(*rc::gen::inRange(1, 70)))) continue;
    RC_ASSERT(bench.frame.sequence > last);
    last = bench.frame.sequence;
    const Time left = exposure_of(*bench.left, bench.frame.left);
    const Time right = exposure_of(*bench.right, bench.frame.right);
    RC_ASSERT(std::chrono::abs(left - right) <= bench.pair->tolerance() + std::chrono::microseconds(2));
    RC_ASSERT(std::chrono::abs(left + (right - left) / 2 - bench.frame.exposure) <=
              std::chrono::microseconds(2));
  }
  const PairStats& stats = bench.pair->stats();
  RC_ASSERT(stats.pairs >= static_cast<std::uint64_t>(bench.taken));
  RC_ASSERT(bench.recorded() == stats.pairs + stats.unpaired);
  const bool kept_pace = bench.pair->left().stats().restarts + bench.pair->right().stats().restarts == 0;
  if (kept_pace && std::chrono::abs(offset) > bench.pair->tolerance() + std::chrono::microseconds(2) &&
      std::chrono::abs(offset) <
          bench.left->period() - bench.pair->tolerance() - std::chrono::microseconds(2))
    RC_ASSERT(stats.pairs == 0u);
  RC_ASSERT(bench.calls.violations.empty());
}

}  // namespace
}  // namespace headway::drivers
