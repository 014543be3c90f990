// SocketCAN on an interface that goes away and comes back, with everything that may be different then.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/socketcan_bench.h"

namespace headway::drivers {
namespace {

using namespace std::chrono_literals;
using hal::CanBusState;
using testing::kFrame;
using Bench = testing::SocketCanBench;

TEST(SocketCanBus, IsGoneWhileTheInterfaceIsDown) {
  Bench bench;
  bench.bus();
  bench.kernel.take_down();
  EXPECT_TRUE(bench.received().empty());
  EXPECT_EQ(bench.bus().state(), CanBusState::kGone);
  EXPECT_FALSE(bench.bus().send(kFrame));
  EXPECT_EQ(bench.bus().stats().gone, 1u);
  bench.clock.advance(500ms);
  bench.received();
  EXPECT_EQ(bench.bus().state(), CanBusState::kGone) << "it is still down";
  bench.kernel.up = true;
  bench.clock.advance(1s);
  bench.received();
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  EXPECT_TRUE(bench.bus().send(kFrame));
  EXPECT_EQ(bench.bus().stats().gone, 1u);
}

TEST(SocketCanBus, SeesByWritingToo) {
  Bench bench;
  bench.bus();
  bench.kernel.unplug();
  EXPECT_FALSE(bench.bus().send(kFrame));
  EXPECT_EQ(bench.bus().state(), CanBusState::kGone);
  EXPECT_EQ(bench.kernel.open_descriptors(), 0u);
}

TEST(SocketCanBus, ComesBackUnderAnotherIndex) {
  Bench bench({.identifiers = {0x130}});
  bench.bus();
  bench.kernel.unplug();
  bench.received();
  ASSERT_EQ(bench.bus().state(), CanBusState::kGone);
  bench.kernel.plug(9);
  bench.clock.advance(500ms);
  bench.received();
  ASSERT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  ASSERT_TRUE(bench.bus().send(kFrame));
  EXPECT_EQ(bench.kernel.sent.back().index, 9);
  bench.kernel.arrive(0x130);
  bench.kernel.arrive(0x131);
  EXPECT_EQ(bench.received().size(), 1u) << "filters are set anew";
}

TEST(SocketCanBus, TriesAgainAfterHalfASecondAndThenEverLessOften) {
  Bench bench;
  bench.bus();
  bench.kernel.unplug();
  const Time lost = bench.clock.now();
  std::vector<Duration> tried;
  std::size_t before = bench.kernel.tries;
  for (; bench.clock.now() < lost + 30s; bench.clock.advance(5ms)) {
    bench.received();
    if (bench.kernel.tries == before) continue;
    before = bench.kernel.tries;
    tried.push_back(bench.kernel.last_try - lost);
  }
  EXPECT_THAT(tried,
              ::testing::ElementsAre(500ms, 1500ms, 3500ms, 7500ms, 12500ms, 17500ms, 22500ms, 27500ms));
}

TEST(SocketCanBus, ForgetsWhatTheOldControllerSaid) {
  Bench bench;
  bench.bus();
  bench.report(CAN_ERR_BUSOFF | CAN_ERR_CNT, 0, 255);
  bench.kernel.unplug();
  bench.received();
  bench.kernel.plug(4);
  bench.clock.advance(500ms);
  bench.received();
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  EXPECT_EQ(bench.bus().stats().transmit_errors, 0);
  EXPECT_EQ(bench.bus().stats().bus_off, 1u) << "counts only grow";
}

TEST(SocketCanBus, ForgetsThatTheOldQueueWasFull) {
  Bench bench;
  bench.kernel.room = 0;
  bench.bus().send(kFrame);
  bench.clock.advance(100ms);
  bench.bus().send(kFrame);
  ASSERT_EQ(bench.bus().state(), CanBusState::kBusOff);
  bench.kernel.unplug();
  bench.received();
  bench.kernel.plug(4);
  bench.clock.advance(500ms);
  bench.received();
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  bench.bus().send(kFrame);
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive) << "the new one is full since this moment only";
}

TEST(SocketCanBus, CountsWhatEachSocketLost) {
  Bench bench;
  bench.bus();
  const auto lose = [&](std::uint32_t frames) {
    bench.kernel.set_dropped(frames);
    bench.kernel.arrive(0x130);
    bench.received();
  };
  lose(7);
  bench.kernel.unplug();
  bench.received();
  bench.kernel.plug(4);
  bench.clock.advance(500ms);
  bench.received();
  lose(5);
  EXPECT_EQ(bench.bus().stats().lost, 12u);
}

TEST(SocketCanBus, LeaksNoDescriptorInTenThousandOpenings) {
  Bench bench;
  for (int i = 0; i < 10'000; ++i) {
    SocketCanBus bus({}, bench.clock, bench.kernel);
    ASSERT_EQ(bench.kernel.open_descriptors(), 1u);
    std::array<hal::CanFrame, 4> frames;
    if (i % 3 == 0) {
      bench.kernel.unplug();
      i % 2 == 0 ? void(bus.receive(frames)) : void(bus.send(kFrame));
      ASSERT_EQ(bench.kernel.open_descriptors(), 0u);
      if (i % 4 == 0) {  // a try that fails half-way
        bench.clock.advance(1s);
        bench.kernel.plug(5);
        bench.kernel.refused_option = SO_RXQ_OVFL;
        bus.receive(frames);
        bench.kernel.refused_option = -1;
        ASSERT_EQ(bench.kernel.open_descriptors(), 0u);
      }
      bench.kernel.plug(3 + i);
      bench.clock.advance(5s);
      bus.receive(frames);
      ASSERT_EQ(bench.kernel.open_descriptors(), 1u);
    }
  }
  EXPECT_EQ(bench.kernel.open_descriptors(), 0u);
  EXPECT_FALSE(bench.kernel.misused);
}

}  // namespace
}  // namespace headway::drivers
