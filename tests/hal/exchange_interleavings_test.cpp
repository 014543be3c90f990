// NewestSlot and BoundedQueue in every interleaving of a few operations, with every value that their memory
// orders let a load see; and proof that a weaker order anywhere would be found.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "hal/exchange.h"
#include "tests/hal/interleavings.h"

namespace headway::hal {
namespace {

using interleavings::Atomic;
using interleavings::explore;
using interleavings::Fault;
using interleavings::memory;
using interleavings::Plain;
using interleavings::Planted;
using interleavings::Program;
using interleavings::Result;

void require(bool holds, const char* what) {
  if (!holds) memory().fail(what);
}

/// The writer publishes 1, 2, ...; the reader looks so many times, and once more when the writer has ended.
Result newest_slot(int published, int looks, const Planted& planted = {}) {
  return explore(
      [=] {
        struct Shared {
          NewestSlot<Plain, Atomic> slot;
          int newest = 0;
          void look() {
            const bool fresh = slot.update();
            const int value = slot.value().value();
            require(fresh ? value > newest : value == newest, "an older value, or one twice");
            newest = value;
          }
        };
        const auto shared = std::make_shared<Shared>();
        return Program{{[=] {
                          for (int i = 1; i <= published; ++i) shared->slot.publish(Plain(i));
                        },
                        [=] {
                          for (int i = 0; i < looks; ++i) shared->look();
                        }},
                       [=] {
                         shared->look();
                         require(shared->newest == published, "the newest value is lost");
                       }};
      },
      planted);
}

/// The writer pushes 1, 2, ...; the reader takes so many times, and the rest when the writer has ended.
template <std::size_t kCapacity>
Result bounded_queue(int pushes, int pops, const Planted& planted = {}) {
  return explore(
      [=] {
        struct Shared {
          BoundedQueue<Plain, kCapacity, Atomic> queue;
          std::vector<int> pushed, popped;
          std::uint64_t dropped = 0;
          void push(int i) {
            if (queue.push(Plain(i)))
              pushed.push_back(i);
            else
              ++dropped;
          }
          bool pop() {
            Plain event;
            if (!queue.pop(event)) return false;
            popped.push_back(event.value());
            return true;
          }
        };
        const auto shared = std::make_shared<Shared>();
        return Program{{[=] {
                          for (int i = 1; i <= pushes; ++i) shared->push(i);
                        },
                        [=] {
                          for (int i = 0; i < pops; ++i) shared->pop();
                        }},
                       [=] {
                         while (shared->pop()) {
                         }
                         require(shared->popped == shared->pushed, "an event is lost, twice or out of order");
                         require(shared->queue.dropped() == shared->dropped, "drops are miscounted");
                         require(shared->pushed.size() >=
                                     std::min<std::size_t>(kCapacity, static_cast<std::size_t>(pushes)),
                                 "dropped where there was room");
                       }};
      },
      planted);
}

/// Adds the runs up.
void expect_no_failure(const Result& result, std::uint64_t at_least, std::uint64_t& all) {
  EXPECT_EQ(result.failed, 0U) << result.failure;
  EXPECT_GE(result.runs, at_least);
  all += result.runs;
}

TEST(NewestSlotInterleavingsSlow, GiveTheNewestValueWholeAndOnce) {
  std::uint64_t runs = 0;
  for (int published = 0; published <= 4; ++published)
    for (int looks = 0; looks <= 4; ++looks) expect_no_failure(newest_slot(published, looks), 1, runs);
  expect_no_failure(newest_slot(5, 5), 3003, runs);
  std::printf("%llu runs\n", static_cast<unsigned long long>(runs));
}

TEST(BoundedQueueInterleavingsSlow, KeepEveryEventInOrderAndCountWhatIsDropped) {
  std::uint64_t runs = 0;
  for (int pushes = 0; pushes <= 3; ++pushes)
    for (int pops = 0; pops <= 3; ++pops) {
      expect_no_failure(bounded_queue<1>(pushes, pops), 1, runs);
      if (pushes + pops <= 5) expect_no_failure(bounded_queue<2>(pushes, pops), 1, runs);
    }
  expect_no_failure(bounded_queue<3>(4, 1), 1, runs);
  std::printf("%llu runs\n", static_cast<unsigned long long>(runs));
}

// The variables, in the order in which they are constructed; and who does it.
constexpr std::size_t kMiddle = 0;
constexpr std::size_t kHead = 0, kTail = 1;
constexpr std::size_t kWriter = 0, kReader = 1;

TEST(NewestSlotInterleavingsSlow, AreCaughtWhenAnyOrderIsWeakerOrAnExchangeIsNone) {
  for (const std::size_t thread : {kWriter, kReader})
    for (const Fault fault : {Fault::kExchangeNoAcquire, Fault::kExchangeNoRelease, Fault::kExchangeInTwo})
      EXPECT_GT(newest_slot(3, 3, {fault, kMiddle, thread}).failed, 0U)
          << "thread " << thread << ", fault " << static_cast<int>(fault);
}

TEST(BoundedQueueInterleavingsSlow, AreCaughtWhenAnyOrderIsWeaker) {
  for (const Planted& planted : {Planted{Fault::kLoadRelaxed, kHead, kWriter},
                                 {Fault::kStoreRelaxed, kHead, kReader},
                                 {Fault::kLoadRelaxed, kTail, kReader},
                                 {Fault::kStoreRelaxed, kTail, kWriter}})
    EXPECT_GT(bounded_queue<1>(3, 2, planted).failed, 0U)
        << "variable " << planted.variable << ", fault " << static_cast<int>(planted.fault);
}

}  // namespace
}  // namespace headway::hal
