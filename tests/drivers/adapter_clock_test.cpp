#include "drivers/adapter_clock.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// An adapter's microseconds, kept in 64 bits beside what it says of them.
struct Crystal {
  double rate = 1;
  std::uint64_t start = 0;
  std::uint32_t us(Time t) const {
    return static_cast<std::uint32_t>(start + static_cast<std::uint64_t>(to_seconds(t) * 1e6 * rate));
  }
};

RC_GTEST_PROP(AdapterClock, IsNoFurtherOffThanItSays, ()) {
  Crystal crystal;
  crystal.rate = 1 + *rc::gen::inRange(-200, 201) * 1e-6;
  crystal.start = *rc::gen::arbitrary<std::uint64_t>() % 0x100000000u;
  AdapterClock clock;
  Time now = at_seconds(*rc::gen::inRange(1, 100'000));
  for (int i = 0; i < 50; ++i) {
    // It is read somewhere between question and answer.
    const Time asked = now, answered = now + microseconds(*rc::gen::inRange(20, 400'000));
    const Time read =
        asked + microseconds(*rc::gen::inRange<std::int64_t>(0, (answered - asked).count() / 1000 + 1));
    clock.set(crystal.us(read), asked, answered);
    now = answered + milliseconds(*rc::gen::inRange(0, 60'000));
    const Time event = now - milliseconds(*rc::gen::inRange(0, 100));
    const auto told = clock.time(crystal.us(event));
    RC_ASSERT(told.has_value());
    RC_ASSERT(std::chrono::abs(*told - event) <= clock.uncertainty(now) + microseconds(25));
  }
}

TEST(AdapterClock, KnowsNothingBeforeItWasSet) {
  const AdapterClock clock;
  EXPECT_FALSE(clock.time(0));
}

TEST(AdapterClock, KeepsAGoodReadingUntilThatIsOlderThanANewOneIsPoor) {
  AdapterClock clock;
  clock.set(0, at_seconds(10), at_seconds(10) + microseconds(100));
  const auto good = clock.time(0);
  clock.set(1'500'000, at_seconds(11), at_seconds(11.5));  // half a second to answer
  EXPECT_EQ(clock.time(0), good);
  clock.set(0, at_seconds(3000), at_seconds(3000.5));
  EXPECT_NE(clock.time(0), good);
}

TEST(AdapterClock, SeesThroughAWrapEitherWay) {
  AdapterClock clock;
  clock.set(0xFFFFFFF0, at_seconds(5), at_seconds(5));
  EXPECT_EQ(clock.time(0x10), at_seconds(5) + microseconds(0x20));
  clock = {};
  clock.set(0x10, at_seconds(5), at_seconds(5));
  EXPECT_EQ(clock.time(0xFFFFFFF0), at_seconds(5) - microseconds(0x20));
}

}  // namespace
}  // namespace headway::drivers
