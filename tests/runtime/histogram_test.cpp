#include "runtime/histogram.h"

#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::runtime {
namespace {

/// The least value that at least that share of all is not above: the definition, on all values.
std::int64_t exact_quantile(std::vector<std::int64_t> values, double share) {
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

/// From a nanosecond to a quarter of an hour, each power of two as likely as the others.
rc::Gen<std::int64_t> durations() {
  return rc::gen::map(
      rc::gen::pair(rc::gen::inRange(0, 40), rc::gen::arbitrary<std::uint64_t>()),
      [](const std::pair<int, std::uint64_t>& drawn) {
        return static_cast<std::int64_t>(drawn.second & ((std::uint64_t{1} << drawn.first) - 1));
      });
}

RC_GTEST_PROP(Histogram, GivesQuantilesThatAreAtMostA32ndTooHigh, ()) {
  const auto values = *rc::gen::nonEmpty(rc::gen::container<std::vector<std::int64_t>>(durations()));
  Histogram histogram;
  for (const std::int64_t value : values) histogram.add(Duration(value));
  RC_ASSERT(histogram.count() == values.size());
  for (const double share : {0.0, 0.01, 0.5, 0.99, 0.999, 1.0}) {
    const std::int64_t exact = exact_quantile(values, share), told = histogram.quantile(share).count();
    RC_ASSERT(told >= exact);
    RC_ASSERT(told - exact <= exact / 32);
  }
  RC_ASSERT(histogram.max().count() == exact_quantile(values, 1));
  RC_ASSERT(histogram.quantile(1) == histogram.max());
}

RC_GTEST_PROP(Histogram, KnowsShortDurationsExactly, ()) {
  const auto values = *rc::gen::nonEmpty(
      rc::gen::container<std::vector<std::int64_t>>(rc::gen::inRange<std::int64_t>(0, 64)));
  Histogram histogram;
  for (const std::int64_t value : values) histogram.add(Duration(value));
  for (const double share : {0.1, 0.5, 0.9})
    RC_ASSERT(histogram.quantile(share).count() == exact_quantile(values, share));
}

TEST(Histogram, TakesWhatLiesOutsideItsScaleForItsEnds) {
  Histogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), Duration(0)) << "of none";
  histogram.add(Duration(-5));
  EXPECT_EQ(histogram.max(), Duration(0));
  histogram.add(Duration::max());
  EXPECT_EQ(histogram.max(), Duration((std::int64_t{1} << 40) - 1));
  EXPECT_EQ(histogram.quantile(1), histogram.max());
  EXPECT_EQ(histogram.count(), 2U);
}

TEST(Histogram, TellsTheTailApart) {
  Histogram histogram;
  for (int i = 0; i < 980; ++i) histogram.add(seconds(10e-6));
  for (int i = 0; i < 19; ++i) histogram.add(seconds(100e-6));
  histogram.add(seconds(1e-3));
  const Spread spread = histogram.spread();
  EXPECT_EQ(spread.count, 1000U);
  EXPECT_NEAR(to_seconds(spread.p50), 10e-6, 10e-6 / 32);
  EXPECT_NEAR(to_seconds(spread.p99), 100e-6, 100e-6 / 32);
  EXPECT_NEAR(to_seconds(spread.p999), 100e-6, 100e-6 / 32);
  EXPECT_EQ(spread.max, seconds(1e-3));
}

// Under the thread sanitizer this also proves that looking is no race.
TEST(Histogram, IsReadWhileItGrows) {
  constexpr std::uint64_t kLast = 100000;
  Histogram histogram;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) histogram.add(Duration(1000));
  });
  for (std::uint64_t before = 0; before < kLast;) {
    const std::uint64_t count = histogram.count();
    ASSERT_GE(count, before);
    before = count;
    const Duration median = histogram.quantile(0.5);
    ASSERT_TRUE(median == Duration(0) || median == Duration(1000));
  }
  writer.join();
}

}  // namespace
}  // namespace headway::runtime
