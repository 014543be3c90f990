#include "runtime/threads.h"

#include <cstring>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>
#include <pthread.h>

namespace headway::runtime {
namespace {

TEST(Threads, HaveNamesOfTheirOwnThatTheSystemCanShow) {
  std::set<std::string> names;
  for (const ThreadKind& kind : kThreads) {
    EXPECT_LE(std::strlen(kind.name), 15U);
    EXPECT_GE(kind.priority, 0);
    names.insert(kind.name);
  }
  EXPECT_EQ(names.size(), kThreads.size());
  EXPECT_GT(kind(ThreadId::kBus).priority, kind(ThreadId::kAdapter).priority);
  EXPECT_GT(kind(ThreadId::kAdapter).priority, kind(ThreadId::kFrames).priority);
}

TEST(Threads, EndWhenAskedAndKeepNothingToSay) {
  std::atomic<int> rounds{0};
  Thread thread(ThreadId::kFrames, [&](const std::atomic<bool>& stop) {
    while (!stop) {
      ++rounds;
      std::this_thread::yield();
    }
  });
  while (rounds < 3) std::this_thread::yield();
  EXPECT_FALSE(thread.ended());
  thread.stop();
  EXPECT_TRUE(thread.ended());
  EXPECT_EQ(thread.failure(), "");
  EXPECT_EQ(thread.refusal(), "") << "an ordinary thread asks for no priority";
}

TEST(Threads, KeepWhatWasThrown) {
  Thread fault(ThreadId::kFrames, [](const auto&) { throw std::runtime_error("the map is full"); });
  fault.stop();
  EXPECT_EQ(fault.failure(), "the map is full");
  Thread number(ThreadId::kFrames, [](const auto&) { throw 7; });
  number.stop();
  EXPECT_FALSE(number.failure().empty());
}

TEST(Threads, RunAsUrgentlyAsTheTableSaysOrSayWhyNot) {
  sched_param param{};
  int policy = -1;
  Thread thread(ThreadId::kBus, [&](const auto&) { pthread_getschedparam(pthread_self(), &policy, &param); });
  thread.stop();
  if (thread.refusal().empty()) {
    EXPECT_EQ(policy, SCHED_FIFO);
    EXPECT_EQ(param.sched_priority, kind(ThreadId::kBus).priority);
  } else {
    EXPECT_NE(thread.refusal().find("headway-bus: priority 70 refused"), std::string::npos)
        << thread.refusal();
    EXPECT_EQ(policy, SCHED_OTHER);
  }
}

TEST(Threads, KeepToTheirProcessor) {
  cpu_set_t mine, processors;
  ASSERT_EQ(sched_getaffinity(0, sizeof mine, &mine), 0);
  int first = 0;
  while (!CPU_ISSET(first, &mine)) ++first;
  CPU_ZERO(&processors);
  Thread thread(ThreadId::kBus,
                [&](const auto&) { pthread_getaffinity_np(pthread_self(), sizeof processors, &processors); },
                {.bus_processor = first});
  thread.stop();
  EXPECT_EQ(CPU_COUNT(&processors), 1);
  EXPECT_TRUE(CPU_ISSET(first, &processors));
}

}  // namespace
}  // namespace headway::runtime
