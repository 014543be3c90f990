#include "drivers/control_clock.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Another machine's clock: runs off by up to 200 ppm, now this way and now that, and may be started anew.
struct OtherClock {
  Time now{};        ///< ours
  Duration apart{};  ///< ours less its: the truth

  void advance(Duration d, double drift) {
    now += d;
    apart += seconds(drift * to_seconds(d));
  }
  void restart() { apart = now.time_since_epoch(); }
  std::uint32_t ms() const {
    return static_cast<std::uint32_t>((now - apart).time_since_epoch() / milliseconds(1));
  }
};

/// How far the estimate is from the truth. Both clocks' milliseconds wrap.
Duration error(const hal::ClockOffset& told, const OtherClock& truth) {
  const Duration wrap = milliseconds(std::int64_t{1} << 32);
  const Duration apart = (told.offset - truth.apart) % wrap;
  return std::min(std::chrono::abs(apart), wrap - std::chrono::abs(apart));
}

RC_GTEST_PROP(ControlClock, TheTruthLiesWithinItsBoundsHoweverLongFramesTravel, ()) {
  const ControlClockConfig config;
  OtherClock other{.now = at_seconds(*rc::gen::inRange(1, 100'000))};
  other.apart =
      other.now.time_since_epoch() - milliseconds(*rc::gen::element<std::int64_t>(
                                         0, 5'000'000, 3'000'000'000, (std::int64_t{1} << 32) - 4'000));
  ControlClock clock(config);
  int told = 0;
  std::uint32_t ms = 0;
  for (int i = 0; i < 40; ++i) {
    // A start within seconds of the wrap, every 49 days, cannot be told from the wrap.
    if (*rc::gen::inRange(0, 15) == 0 && ms < 4'294'957'296) other.restart();
    ms = other.ms();
    const double drift = *rc::gen::inRange(-200, 201) * 1e-6;
    // One of three in a row is quick; the others take up to 0.9 s.
    const bool quick = i % ControlClock::kReadings == 1;
    const Duration travel = microseconds(*rc::gen::inRange(0, quick ? 10'001 : 900'000));
    other.advance(travel, drift);
    clock.hear(ms, other.now);
    const Duration wait = milliseconds(*rc::gen::inRange(0, 400));
    for (const Duration d : {Duration{}, wait, milliseconds(900) - wait}) {
      other.advance(d, drift);
      const auto offset = clock.offset(other.now);
      if (!offset) continue;
      ++told;
      RC_ASSERT(error(*offset, other) <= offset->uncertainty + microseconds(1));
      RC_ASSERT(offset->uncertainty < milliseconds(500));
    }
  }
  RC_CLASSIFY(told > 60);
}

TEST(ControlClock, IsKnownToHalfTheLargestDelayWhereFramesAreQuick) {
  OtherClock other{.now = at_seconds(20), .apart = seconds(3.25)};
  ControlClock clock;
  for (int i = 0; i < 20; ++i) {
    other.advance(seconds(1), 50e-6);
    const std::uint32_t ms = other.ms();
    other.advance(milliseconds(1), 50e-6);
    clock.hear(ms, other.now);
  }
  const auto offset = clock.offset(other.now);
  ASSERT_TRUE(offset);
  EXPECT_LE(error(*offset, other), offset->uncertainty);
  EXPECT_LT(offset->uncertainty, milliseconds(6));
}

class HeardClock : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const int s : {7, 8, 9}) {
      EXPECT_FALSE(clock_.offset(at_seconds(s)));
      clock_.hear(static_cast<std::uint32_t>(s * 1000 - 2000), at_seconds(s));
    }
    ASSERT_TRUE(clock_.offset(at_seconds(9)));
  }
  ControlClock clock_;
};

TEST_F(HeardClock, IsLessSureTheLongerItIsNotHeardAndUnknownAfterFiveSeconds) {
  EXPECT_GT(clock_.offset(at_seconds(13))->uncertainty, clock_.offset(at_seconds(10))->uncertainty);
  EXPECT_TRUE(clock_.is_heard(at_seconds(14)));
  EXPECT_FALSE(clock_.is_heard(at_seconds(14.001)));
  EXPECT_FALSE(clock_.offset(at_seconds(14.001)));
}

TEST_F(HeardClock, BeginsAnewWhenItWasNotHeardForFiveSeconds) {
  clock_.hear(9000, at_seconds(15));  // 4 s ahead of what it was
  EXPECT_FALSE(clock_.offset(at_seconds(15)));
}

TEST_F(HeardClock, BeginsAnewWhenItHasGoneBack) {
  clock_.hear(30, at_seconds(10));
  EXPECT_TRUE(clock_.is_heard(at_seconds(10)));
  EXPECT_FALSE(clock_.offset(at_seconds(10)));
  clock_.hear(1030, at_seconds(11));
  clock_.hear(2030, at_seconds(12));
  ASSERT_TRUE(clock_.offset(at_seconds(12)));
  EXPECT_NEAR(to_seconds(clock_.offset(at_seconds(12))->offset), 9.97, 0.006);
}

TEST_F(HeardClock, BeginsAnewWhenItWasPutForward) {
  clock_.hear(3'600'000, at_seconds(10));
  EXPECT_FALSE(clock_.offset(at_seconds(10)));
}

}  // namespace
}  // namespace headway::drivers
