#include "drivers/back_off.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

using std::chrono::milliseconds;

/// When the next tries are due, each failing at once, as waits from one to the next.
std::vector<Duration> waits_of(BackOff& back_off, Time now, int tries) {
  std::vector<Duration> waits;
  for (int i = 0; i < tries; ++i) {
    EXPECT_FALSE(back_off.next() > now && back_off.is_due(back_off.next() - Duration(1)));
    EXPECT_TRUE(back_off.is_due(back_off.next()));
    waits.push_back(back_off.next() - now);
    now = back_off.next();
    back_off.failed(now);
  }
  return waits;
}

TEST(BackOff, WaitsTwiceAsLongAfterEachFailureUpToTheLongest) {
  BackOff back_off({.first = milliseconds(500), .longest = milliseconds(3000)});
  back_off.begin(at_seconds(7));
  const std::vector<Duration> expected{milliseconds(500), milliseconds(1000), milliseconds(2000),
                                       milliseconds(3000), milliseconds(3000)};
  EXPECT_EQ(waits_of(back_off, at_seconds(7), 5), expected);
  back_off.begin(at_seconds(100));
  EXPECT_EQ(waits_of(back_off, at_seconds(100), 5), expected) << "and anew";
}

TEST(BackOff, WaitsTheFirstPauseWhereTheDeviceNeverWorked) {
  BackOff back_off({.first = milliseconds(500), .longest = milliseconds(3000)});
  back_off.failed(at_seconds(7));
  EXPECT_EQ(back_off.next(), at_seconds(7) + milliseconds(500));
}

TEST(BackOff, TriesAtOnceWhereThatIsWishedAndThenAsEver) {
  BackOff back_off({.first = milliseconds(500), .longest = milliseconds(3000)});
  back_off.begin_at_once(at_seconds(7));
  EXPECT_EQ(waits_of(back_off, at_seconds(7), 3),
            (std::vector<Duration>{Duration::zero(), milliseconds(500), milliseconds(1000)}));
}

RC_GTEST_PROP(BackOff, NeverWaitsShorterThanTheFirstNorLongerThanTheLongest, ()) {
  const auto first = *rc::gen::inRange(1, 2000);
  const BackOffConfig config{.first = milliseconds(first),
                             .longest = milliseconds(first + *rc::gen::inRange(0, 10'000))};
  RC_ASSERT(config.is_sound());
  BackOff back_off(config);
  back_off.begin(at_seconds(1));
  for (const Duration wait : waits_of(back_off, at_seconds(1), 20))
    RC_ASSERT(wait >= config.first && wait <= config.longest);
}

TEST(BackOff, IsNotSoundWithoutAPauseOrWithTheLongestShorterThanTheFirst) {
  EXPECT_FALSE(BackOffConfig{.first = {}}.is_sound());
  EXPECT_FALSE((BackOffConfig{.longest = milliseconds(499)}).is_sound());
  EXPECT_FALSE((BackOffConfig{.longest = std::chrono::hours(2)}).is_sound());
}

}  // namespace
}  // namespace headway::drivers
