// The explorer itself, on programs whose outcomes the standard and the literature give (litmus tests: Alglave
// et al., "Herding cats", TOPLAS 2014).
#include "tests/hal/interleavings.h"

#include <memory>
#include <set>
#include <string>

#include <gtest/gtest.h>

namespace headway::interleavings {
namespace {

constexpr auto kRelaxed = std::memory_order_relaxed;
constexpr auto kAcquire = std::memory_order_acquire;
constexpr auto kRelease = std::memory_order_release;
constexpr auto kBoth = std::memory_order_acq_rel;

struct Shared {
  Atomic<int> x{0}, y{0};
  Plain data;
  int a = -1, b = -1;
};

/// What two threads find out, over all runs.
struct Outcomes {
  std::set<std::pair<int, int>> seen;
  Result result;
};

template <class First, class Second>
Outcomes outcomes(First first, Second second) {
  Outcomes all;
  all.result = explore([&] {
    const auto shared = std::make_shared<Shared>();
    return Program{{[=] { first(*shared); }, [=] { second(*shared); }}, [shared, &all] {
                     all.seen.insert({shared->a, shared->b});
                   }};
  });
  return all;
}

using Pairs = std::set<std::pair<int, int>>;

TEST(Interleavings, AreAllThereAre) {
  for (const auto [first, second, expected] : {std::array{1, 1, 2}, {2, 3, 10}, {4, 4, 70}, {0, 5, 1}}) {
    const auto times = [](int count) {
      return [count](Shared& s) {
        for (int i = 0; i < count; ++i) s.x.fetch_add(1, kRelaxed);
      };
    };
    const Outcomes all = outcomes(times(first), times(second));
    EXPECT_EQ(all.result.runs, static_cast<std::uint64_t>(expected)) << "binomial coefficient";
  }
}

TEST(Interleavings, LetStoresWaitInBuffers) {
  const auto one = [](Shared& s) {
    s.x.store(1, kRelease);
    s.a = s.y.load(kAcquire);
  };
  const auto two = [](Shared& s) {
    s.y.store(1, kRelease);
    s.b = s.x.load(kAcquire);
  };
  EXPECT_EQ(outcomes(one, two).seen, (Pairs{{0, 0}, {0, 1}, {1, 0}, {1, 1}}));
}

TEST(Interleavings, PassAMessageOnlyFromReleaseToAcquire) {
  const auto sends = [](std::memory_order order) {
    return [order](Shared& s) {
      s.x.store(1, kRelaxed);
      s.y.store(1, order);
    };
  };
  const auto receives = [](std::memory_order order) {
    return [order](Shared& s) {
      s.a = s.y.load(order);
      s.b = s.x.load(kRelaxed);
    };
  };
  EXPECT_EQ(outcomes(sends(kRelease), receives(kAcquire)).seen, (Pairs{{0, 0}, {0, 1}, {1, 1}}));
  EXPECT_TRUE(outcomes(sends(kRelaxed), receives(kAcquire)).seen.contains({1, 0}));
  EXPECT_TRUE(outcomes(sends(kRelease), receives(kRelaxed)).seen.contains({1, 0}));
}

TEST(Interleavings, CarryAMessageThroughAnExchangeInBetween) {
  const auto sends = [](Shared& s) {
    s.data = Plain(7);
    s.x.store(1, kRelease);
  };
  const auto receives = [](Shared& s) {
    if (s.x.fetch_add(1, kRelaxed) != 1) return;  // goes on with what the store released
    if (s.x.load(kAcquire) == 2) s.a = s.data.value();
  };
  const Outcomes all = outcomes(sends, receives);
  EXPECT_EQ(all.result.failed, 0U) << all.result.failure;
  EXPECT_EQ(all.seen, (Pairs{{-1, -1}, {7, -1}}));
}

TEST(Interleavings, NeverGoBackInOneVariablesHistory) {
  const auto writes = [](Shared& s) {
    s.x.store(1, kRelaxed);
    s.x.store(2, kRelaxed);
  };
  const auto reads = [](Shared& s) {
    s.a = s.x.load(kRelaxed);
    s.b = s.x.load(kRelaxed);
  };
  EXPECT_EQ(outcomes(writes, reads).seen, (Pairs{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}));
}

TEST(Interleavings, LoseNoExchange) {
  const auto adds = [](int Shared::*result) {
    return [result](Shared& s) { s.*result = s.x.fetch_add(1, kRelaxed); };
  };
  EXPECT_EQ(outcomes(adds(&Shared::a), adds(&Shared::b)).seen, (Pairs{{0, 1}, {1, 0}}));
}

TEST(Interleavings, KnowARaceWhicheverCameFirst) {
  const auto writes = [](Shared& s) { s.data = Plain(1); };
  const auto reads = [](Shared& s) { s.a = s.data.value(); };
  EXPECT_EQ(outcomes(writes, reads).result.failure, "race: read while it is written");
  EXPECT_EQ(outcomes(reads, writes).result.failure, "race: written while it is read");
  EXPECT_EQ(outcomes(writes, writes).result.failure, "race: written by both");
  EXPECT_EQ(outcomes(reads, reads).result.failure, "");
}

TEST(Interleavings, KnowARaceAfterTheRelease) {
  const auto writes_too_late = [](Shared& s) {
    s.x.store(1, kRelease);
    s.data = Plain(1);
  };
  const auto reads = [](Shared& s) {
    if (s.x.exchange(2, kBoth) == 1) s.a = s.data.value();
  };
  EXPECT_GT(outcomes(writes_too_late, reads).result.failed, 0U);
}

}  // namespace
}  // namespace headway::interleavings
