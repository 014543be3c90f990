#include "hal/exchange.h"

#include <deque>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::hal {
namespace {

TEST(NewestSlot, GivesTheDefaultBeforeTheFirstValue) {
  NewestSlot<int> slot;
  EXPECT_FALSE(slot.update());
  EXPECT_EQ(slot.value(), 0);
}

// Any order of writes and reads: the reader sees the newest value, once.
RC_GTEST_PROP(NewestSlot, GivesTheNewestValueForAnyOrderOfWritesAndReads, (const std::vector<bool>& writes)) {
  NewestSlot<int> slot;
  int written = 0, read = 0;
  for (const bool write : writes) {
    if (write) {
      slot.publish(++written);
      continue;
    }
    RC_ASSERT(slot.update() == (written != read));
    read = written;
    RC_ASSERT(slot.value() == written);
    RC_ASSERT(!slot.update());
  }
}

// Under the thread sanitizer this also proves that no byte is read while it is written.
TEST(NewestSlot, NeverTearsAValueBetweenTwoThreads) {
  struct Wide {
    std::array<std::uint64_t, 32> copies{};
  };
  constexpr std::uint64_t kLast = 20000;
  NewestSlot<Wide> slot;
  std::thread writer([&] {
    Wide value;
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      value.copies.fill(i);
      slot.publish(value);
    }
  });
  std::uint64_t newest = 0;
  while (newest < kLast) {
    if (!slot.update()) continue;
    const auto& copies = slot.value().copies;
    for (const std::uint64_t copy : copies) ASSERT_EQ(copy, copies[0]);
    ASSERT_GT(copies[0], newest);
    newest = copies[0];
  }
  writer.join();
}

RC_GTEST_PROP(BoundedQueue, BehavesAsAQueueThatDropsNewEventsWhenFull, (const std::vector<bool>& pushes)) {
  BoundedQueue<int, 4> queue;
  std::deque<int> model;
  std::uint64_t dropped = 0;
  int next = 0;
  for (const bool push : pushes) {
    if (push) {
      const bool room = model.size() < 4;
      RC_ASSERT(queue.push(next) == room);
      if (room)
        model.push_back(next);
      else
        ++dropped;
      ++next;
      continue;
    }
    int event = -1;
    RC_ASSERT(queue.pop(event) == !model.empty());
    if (model.empty()) continue;
    RC_ASSERT(event == model.front());
    model.pop_front();
  }
  RC_ASSERT(queue.dropped() == dropped);
}

TEST(BoundedQueue, KeepsTheOrderBetweenTwoThreads) {
  constexpr int kEvents = 20000;
  BoundedQueue<int, 16> queue;
  std::thread writer([&] {
    for (int i = 0; i < kEvents;)
      if (queue.push(i)) ++i;
  });
  for (int expected = 0; expected < kEvents;) {
    int event = -1;
    if (!queue.pop(event)) continue;
    ASSERT_EQ(event, expected);
    ++expected;
  }
  writer.join();
}

}  // namespace
}  // namespace headway::hal
