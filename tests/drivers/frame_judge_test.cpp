// Which frames are usable, and what a gap in the count says.
#include "drivers/frame_judge.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

constexpr std::size_t kBytes = 1000;
constexpr Duration kPeriod = std::chrono::milliseconds(33);

class FrameJudgeTest : public ::testing::Test {
 protected:
  FilledBuffer next() {
    now_ += kPeriod;
    return {.sequence = ++sequence_,
            .stamp = now_.time_since_epoch() - std::chrono::milliseconds(2),
            .is_monotonic = true,
            .bytes = kBytes};
  }
  FrameKind judge(const FilledBuffer& frame) { return judge_.judge(frame, now_).kind; }

  FrameJudge judge_{FrameMeasure{kBytes, std::chrono::milliseconds(8), std::chrono::milliseconds(3)}};
  Time now_ = at_seconds(50);
  std::uint32_t sequence_ = 0;
};

TEST_F(FrameJudgeTest, RefusesWhatIsMarkedOrCutShort) {
  FilledBuffer frame = next();
  EXPECT_EQ(judge(frame), FrameKind::kUsable);
  frame = next();
  frame.is_marked = true;
  EXPECT_EQ(judge(frame), FrameKind::kDamaged);
  frame = next();
  frame.bytes = kBytes - 1;
  EXPECT_EQ(judge(frame), FrameKind::kDamaged);
  EXPECT_EQ(judge(next()), FrameKind::kUsable);
}

TEST_F(FrameJudgeTest, CallsARepeatedStampFrozenHoweverLongItLasts) {
  const FilledBuffer first = next();
  EXPECT_EQ(judge(first), FrameKind::kUsable);
  for (int i = 0; i < 200; ++i) {
    FilledBuffer frame = next();
    frame.stamp = first.stamp;
    EXPECT_EQ(judge(frame), FrameKind::kFrozen);
  }
  EXPECT_EQ(judge(next()), FrameKind::kUsable);
}

TEST_F(FrameJudgeTest, RefusesStampsThatCannotBeThisClocks) {
  FilledBuffer frame = next();
  frame.is_monotonic = false;
  EXPECT_EQ(judge(frame), FrameKind::kWrongClock);
  frame = next();
  frame.stamp += seconds(0.004);  // 2 ms after it was taken
  EXPECT_EQ(judge(frame), FrameKind::kWrongClock);
  frame = next();
  frame.stamp += seconds(1.7e9);  // the time of day
  EXPECT_EQ(judge(frame), FrameKind::kWrongClock);
  frame = next();
  frame.stamp -= seconds(2.1);
  EXPECT_EQ(judge(frame), FrameKind::kWrongClock);
  frame = next();
  EXPECT_EQ(judge(frame), FrameKind::kUsable);
  frame = next();
  frame.stamp -= 2 * kPeriod;  // before the frame before
  EXPECT_EQ(judge(frame), FrameKind::kWrongClock);
  EXPECT_EQ(judge(next()), FrameKind::kUsable);
}

TEST_F(FrameJudgeTest, PutsTheExposureBeforeTheEndOrAfterTheStart) {
  FilledBuffer frame = next();
  EXPECT_EQ(judge_.judge(frame, now_).exposure, Time(frame.stamp) - std::chrono::milliseconds(7));
  frame = next();
  frame.stamp_at = FilledBuffer::StampAt::kStartOfExposure;
  EXPECT_EQ(judge_.judge(frame, now_).exposure, Time(frame.stamp) + std::chrono::milliseconds(4));
}

RC_GTEST_FIXTURE_PROP(FrameJudgeTest, CountsEveryGapFromTheFirstFrameOnThoughTheCountRunsOver, ()) {
  sequence_ = *rc::gen::element(0U, 77U, UINT32_MAX - 20);
  const auto gaps = *rc::gen::container<std::vector<std::uint32_t>>(rc::gen::inRange(0U, 9U));
  std::uint64_t lost = judge_.judge(next(), now_).lost, expected = 0;
  RC_ASSERT(lost == 0);
  for (const std::uint32_t gap : gaps) {
    sequence_ += gap;
    expected += gap;
    lost += judge_.judge(next(), now_).lost;
  }
  RC_ASSERT(lost == expected);
}

TEST_F(FrameJudgeTest, CountsNothingWhenTheCountBeginsAnew) {
  for (const std::uint32_t high : {5U, 1U << 20, UINT32_MAX - 5}) {
    sequence_ = high;
    judge_.forget_sequence();
    EXPECT_EQ(judge_.judge(next(), now_).lost, 0u);
    sequence_ = high == UINT32_MAX - 5 ? 1U << 30 : 0;
    EXPECT_EQ(judge_.judge(next(), now_).lost, 0u);
    ++sequence_;
    EXPECT_EQ(judge_.judge(next(), now_).lost, 1u);
  }
}

}  // namespace
}  // namespace headway::drivers
