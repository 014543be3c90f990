// SocketCAN on a scripted kernel: every fault that the real one can show, without one.
#include "drivers/socketcan_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/drivers/socketcan_bench.h"
#include "tests/heap_count.h"

namespace headway::drivers {
namespace {

using namespace std::chrono_literals;
using hal::CanBusState;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::kFrame, testing::ScriptedCanKernel;
using Bench = testing::SocketCanBench;

std::string fault_of(Bench& bench) {
  try {
    bench.bus();
  } catch (const Error& e) {
    return e.what();
  }
  return "no fault";
}

// --- receiving and sending ---

RC_GTEST_PROP(SocketCanBus, HandsOverEveryDataFrameInOrder, ()) {
  Bench bench;
  bench.bus();
  std::vector<std::uint32_t> expected, got;
  std::uint64_t unusable = 0;
  const int rounds = *rc::gen::inRange(1, 20);
  for (int round = 0; round < rounds; ++round) {
    const int arriving = *rc::gen::inRange(0, 60);
    for (int i = 0; i < arriving; ++i) {
      can_frame frame{};
      frame.can_id = *rc::gen::inRange<canid_t>(0, 0x800);
      frame.can_dlc = *rc::gen::inRange<__u8>(0, 9);
      const canid_t flag = *rc::gen::weightedElement<canid_t>({{8, 0}, {1, CAN_EFF_FLAG}, {1, CAN_RTR_FLAG}});
      if (flag == 0)
        expected.push_back(frame.can_id);
      else
        ++unusable;
      frame.can_id |= flag;
      bench.kernel.arrive(frame);
    }
    for (const hal::CanFrame& f : bench.received(*rc::gen::inRange<std::size_t>(0, 80))) got.push_back(f.id);
  }
  for (auto rest = bench.received(); !rest.empty(); rest = bench.received())
    for (const hal::CanFrame& f : rest) got.push_back(f.id);
  const hal::CanBusStats stats = bench.bus().stats();
  RC_ASSERT(stats.received == got.size());
  RC_ASSERT(stats.unusable + stats.lost + stats.received == expected.size() + unusable);
  if (stats.lost == 0) RC_ASSERT(got == expected);
}

TEST(SocketCanBus, KeepsNothingOfTheFrameBefore) {
  Bench bench;
  bench.bus();
  bench.kernel.arrive(0x100, {1, 2, 3, 4, 5, 6, 7, 8});
  std::array<hal::CanFrame, 1> one;
  ASSERT_EQ(bench.bus().receive(one), 1u);
  can_frame dirty{};
  dirty.can_id = 0x101;
  dirty.can_dlc = 1;
  std::fill_n(dirty.data, 8, __u8{0xEE});
  bench.kernel.arrive(dirty);
  ASSERT_EQ(bench.bus().receive(one), 1u);
  EXPECT_EQ(one[0].dlc, 1);
  EXPECT_THAT(one[0].data, ::testing::ElementsAre(0xEE, 0, 0, 0, 0, 0, 0, 0));
}

TEST(SocketCanBus, PassesOnOnlyTheIdentifiersAskedFor) {
  Bench bench({.identifiers = {0x130, 0x711}});
  bench.bus();
  for (const canid_t id : {0x130u, 0x131u, 0x711u, 0x130u | CAN_EFF_FLAG, 0x130u | CAN_RTR_FLAG})
    bench.kernel.arrive(id, {7});
  const auto frames = bench.received();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].id, 0x130u);
  EXPECT_EQ(frames[1].id, 0x711u);
  bench.report(CAN_ERR_BUSOFF);
  EXPECT_EQ(bench.bus().state(), CanBusState::kBusOff) << "a filter must not hide the controller's faults";
}

TEST(SocketCanBus, SendsWhatItIsGiven) {
  Bench bench;
  ASSERT_TRUE(bench.bus().send(kFrame));
  ASSERT_EQ(bench.kernel.sent.size(), 1u);
  const can_frame& raw = bench.kernel.sent[0].frame;
  EXPECT_EQ(raw.can_id, 0x123u);
  EXPECT_EQ(raw.can_dlc, 2);
  EXPECT_EQ(raw.data[0], 1);
  EXPECT_EQ(raw.data[1], 2);
  EXPECT_EQ(bench.bus().stats().sent, 1u);
}

TEST(SocketCanBus, RefusesWhatNoClassicFrameCanHold) {
  Bench bench;
  EXPECT_FALSE(bench.bus().send({.id = 0x800}));
  EXPECT_FALSE(bench.bus().send({.id = 1, .dlc = 9}));
  EXPECT_TRUE(bench.kernel.sent.empty());
  EXPECT_EQ(bench.bus().stats().refused, 2u);
}

// --- stamps ---

TEST(SocketCanBus, StampsWithTheMonotonicTimeOfArrival) {
  Bench bench;
  bench.bus();
  bench.clock.advance(7ms);
  const Time arrived = bench.clock.now();
  bench.kernel.arrive(0x130);
  bench.clock.advance(5ms);
  const auto frames = bench.received();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].stamp, arrived);
}

RC_GTEST_PROP(SocketCanBus, StampsNeverLeaveTheTimeSinceTheLastRead, ()) {
  Bench bench;
  bench.bus();
  const int cycles = *rc::gen::inRange(1, 10);
  for (int i = 0; i < cycles; ++i) {
    const Time last = bench.clock.now();
    bench.received();
    bench.clock.advance(Duration(*rc::gen::inRange(0, 5'000'000)));
    bench.kernel.arrive(0x130);
    // Somebody sets the time of day, by hours.
    bench.kernel.wall_ahead += std::chrono::seconds(*rc::gen::inRange(-10'000, 10'000));
    bench.clock.advance(Duration(*rc::gen::inRange(0, 5'000'000)));
    const auto frames = bench.received();
    RC_ASSERT(frames.size() == 1u);
    RC_ASSERT(frames[0].stamp >= last);
    RC_ASSERT(frames[0].stamp <= bench.clock.now());
  }
}

// --- what does not fit ---

TEST(SocketCanBus, CountsWhatOverflowed) {
  Bench bench;
  bench.bus();
  const auto flood = [&](std::size_t frames) {
    for (std::size_t i = 0; i < frames; ++i) bench.kernel.arrive(0x200);
    bench.received();
    bench.kernel.arrive(0x200);  // the kernel tells with the next frame that it keeps
    bench.received();
  };
  flood(ScriptedCanKernel::kQueue + 40);
  EXPECT_EQ(bench.bus().stats().lost, 40u);
  flood(ScriptedCanKernel::kQueue);
  EXPECT_EQ(bench.bus().stats().lost, 40u);
  flood(ScriptedCanKernel::kQueue + 2);
  EXPECT_EQ(bench.bus().stats().lost, 42u);
}

TEST(SocketCanBus, CountsWhatOverflowedWhenTheKernelsCountComesRound) {
  Bench bench;
  bench.bus();
  bench.kernel.set_dropped(0xFFFFFFF0u);
  bench.kernel.arrive(0x200);
  bench.received();
  const std::uint64_t before = bench.bus().stats().lost;
  bench.kernel.set_dropped(0x10u);
  bench.kernel.arrive(0x200);
  bench.received();
  EXPECT_EQ(bench.bus().stats().lost - before, 0x20u);
}

TEST(SocketCanBus, CountsWhatTheControllerItselfLost) {
  Bench bench;
  bench.bus();
  bench.report(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW);
  EXPECT_EQ(bench.bus().stats().lost, 1u);
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
}

TEST(SocketCanBus, RefusesWithoutWaitingWhenTheQueueIsFull) {
  Bench bench;
  bench.kernel.room = 10;
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(bench.bus().send(kFrame));
  EXPECT_FALSE(bench.bus().send(kFrame));
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  EXPECT_EQ(bench.bus().stats().refused, 1u);
  ++bench.kernel.room;
  EXPECT_TRUE(bench.bus().send(kFrame));
}

TEST(SocketCanBus, IsAtFaultAfter100MillisecondsWithoutProgress) {
  Bench bench;
  bench.kernel.room = 0;
  for (int cycle = 0; cycle < 20; ++cycle, bench.clock.advance(5ms)) {
    EXPECT_FALSE(bench.bus().send(kFrame));
    ASSERT_EQ(bench.bus().state(), CanBusState::kErrorActive) << "after " << cycle * 5 << " ms";
  }
  for (int cycle = 0; cycle < 20; ++cycle, bench.clock.advance(5ms)) {
    EXPECT_FALSE(bench.bus().send(kFrame));
    ASSERT_EQ(bench.bus().state(), CanBusState::kBusOff);
  }
  EXPECT_EQ(bench.bus().stats().bus_off, 1u);
  bench.kernel.room = 100;
  EXPECT_TRUE(bench.bus().send(kFrame));
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
}

TEST(SocketCanBus, AnyProgressBeginsThe100MillisecondsAnew) {
  Bench bench;
  for (int cycle = 0; cycle < 100; ++cycle, bench.clock.advance(5ms)) {
    bench.kernel.room = bench.kernel.sent.size() + (cycle % 19 == 0 ? 1 : 0);
    EXPECT_EQ(bench.bus().send(kFrame), cycle % 19 == 0);
    ASSERT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  }
}

// --- what the controller reports ---

TEST(SocketCanBus, ReportsWhatTheControllerTells) {
  Bench bench;
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  bench.report(CAN_ERR_CRTL | CAN_ERR_CNT, CAN_ERR_CRTL_TX_WARNING, 97, 3);
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorWarning);
  EXPECT_EQ(bench.bus().stats().transmit_errors, 97);
  EXPECT_EQ(bench.bus().stats().receive_errors, 3);
  bench.report(CAN_ERR_CRTL | CAN_ERR_CNT, CAN_ERR_CRTL_RX_PASSIVE, 90, 128);
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorPassive);
  EXPECT_EQ(bench.bus().stats().receive_errors, 128);
  bench.report(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_WARNING);
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorWarning);
  EXPECT_EQ(bench.bus().stats().receive_errors, 128) << "a frame without counters says nothing of them";
  bench.report(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE);
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  EXPECT_EQ(bench.bus().stats().received, 0u);
  EXPECT_EQ(bench.bus().stats().unusable, 0u);
}

TEST(SocketCanBus, IsOffTheBusUntilTheControllerIsRestarted) {
  Bench bench;
  bench.bus();
  bench.report(CAN_ERR_BUSOFF | CAN_ERR_CNT, 0, 255);
  bench.report(CAN_ERR_BUSOFF);
  EXPECT_EQ(bench.bus().state(), CanBusState::kBusOff);
  EXPECT_EQ(bench.bus().stats().bus_off, 1u);
  EXPECT_FALSE(bench.bus().send(kFrame)) << "the kernel would keep it until it is stale";
  EXPECT_TRUE(bench.kernel.sent.empty());
  bench.report(CAN_ERR_RESTARTED);
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
  EXPECT_EQ(bench.bus().stats().transmit_errors, 0);
  EXPECT_TRUE(bench.bus().send(kFrame));
}

TEST(SocketCanBus, KnowsWhenItOpensTheInterfaceThatItsControllerIsOffTheBusAlready) {
  Bench bench;
  bench.kernel.runs = false;
  const auto is_off_and_comes_back = [&](std::uint64_t times) {
    EXPECT_EQ(bench.bus().state(), CanBusState::kBusOff);
    EXPECT_EQ(bench.bus().stats().bus_off, times);
    EXPECT_FALSE(bench.bus().send(kFrame)) << "the kernel would throw it away";
    bench.report(CAN_ERR_RESTARTED);
    EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
    EXPECT_TRUE(bench.bus().send(kFrame));
  };
  is_off_and_comes_back(1);
  bench.kernel.unplug();
  bench.received();
  ASSERT_EQ(bench.bus().state(), CanBusState::kGone);
  bench.kernel.plug(9);
  bench.clock.advance(5s);
  bench.received();
  is_off_and_comes_back(2);
}

TEST(SocketCanBus, WaitsForAnInterfaceThatRunsSoonAfterItWasSetUp) {
  Bench bench;
  bench.kernel.runs = false;
  bench.received();
  ASSERT_EQ(bench.bus().state(), CanBusState::kBusOff);
  bench.kernel.runs = true;
  bench.received();
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive) << "though nobody says a word";
  EXPECT_TRUE(bench.bus().send(kFrame));
  bench.report(CAN_ERR_BUSOFF);
  bench.received();
  EXPECT_EQ(bench.bus().state(), CanBusState::kBusOff) << "what the controller says counts more";
}

TEST(SocketCanBus, IsOnTheBusAgainWhenItHearsOthers) {
  Bench bench;
  bench.bus();
  bench.report(CAN_ERR_BUSOFF);
  bench.kernel.arrive(0x130);
  EXPECT_EQ(bench.received().size(), 1u);
  EXPECT_EQ(bench.bus().state(), CanBusState::kErrorActive);
}

TEST(SocketCanBus, AFloodOfErrorFramesEndsACycleAllTheSame) {
  // A kernel that has an error frame for every read.
  class Flood final : public ScriptedCanKernel {
   public:
    using ScriptedCanKernel::ScriptedCanKernel;
    int recvmmsg(int fd, std::span<mmsghdr> into) noexcept override {
      for (std::size_t i = 0; i < into.size(); ++i)
        arrive(CAN_ERR_FLAG | CAN_ERR_CRTL, {0, 0, 0, 0, 0, 0, 0, 0});
      return ScriptedCanKernel::recvmmsg(fd, into);
    }
  };
  hal::ManualClock clock;
  Flood flood(clock);
  SocketCanBus bus({}, clock, flood);
  std::array<hal::CanFrame, 64> frames;
  EXPECT_EQ(bus.receive(frames), 0u);
}

TEST(SocketCanBus, UsesNoHeapWhateverHappens) {
  Bench bench;
  SocketCanBus& bus = bench.bus();
  std::array<hal::CanFrame, 64> frames;
  const std::uint64_t before = heap_allocations();
  std::uint64_t received = 0;
  for (int i = 0; i < 5000; ++i, bench.clock.advance(5ms)) {
    for (int k = 0; k < i % 50; ++k) bench.kernel.arrive(0x130u, {1, 2, 3});
    if (i % 100 == 7) bench.kernel.arrive(CAN_ERR_FLAG | CAN_ERR_BUSOFF, {0, 0, 0, 0, 0, 0, 0, 0});
    if (i % 1000 == 300) bench.kernel.unplug();
    if (i % 1000 == 700) bench.kernel.plug(i);
    bench.kernel.room = i % 10 == 0 ? 0 : 1 << 16;
    received += bus.receive(frames);
    bus.send(kFrame);
    bus.stats();
  }
  EXPECT_EQ(heap_allocations(), before);
  EXPECT_GT(received, 10'000u);
  EXPECT_EQ(bus.stats().gone, 5u);
  EXPECT_GT(bus.stats().sent, 1000u);
}

// --- what is wrong at the start ---

TEST(SocketCanBus, SaysWhatIsWrongWithTheInterface) {
  Bench absent({.interface = "can7"});
  EXPECT_THROW(absent.bus(), InputError);
  EXPECT_THAT(fault_of(absent),
              AllOf(HasSubstr("can7"), HasSubstr("no such interface"), HasSubstr("ip link")));

  Bench down;
  down.kernel.up = false;
  EXPECT_THROW(down.bus(), InputError);
  EXPECT_THAT(fault_of(down),
              AllOf(HasSubstr("can0"), HasSubstr("is down"), HasSubstr("ip link set can0 up")));

  Bench other;
  other.kernel.is_can = false;
  EXPECT_THROW(other.bus(), InputError);
  EXPECT_THAT(fault_of(other), AllOf(HasSubstr("can0"), HasSubstr("no CAN interface")));

  for (Bench* bench : {&absent, &down, &other}) EXPECT_EQ(bench->kernel.open_descriptors(), 0u);
}

TEST(SocketCanBus, SaysWhatTheKernelLacks) {
  Bench without;
  without.kernel.has_can = false;
  EXPECT_THAT(fault_of(without),
              AllOf(HasSubstr("can0"), HasSubstr("no CAN socket"), HasSubstr("modprobe can-raw")));
  for (const int option : {int{CAN_RAW_FILTER}, int{CAN_RAW_ERR_FILTER}, SO_TIMESTAMPING, SO_RXQ_OVFL}) {
    Bench old({.identifiers = {0x130}});
    old.kernel.refused_option = option;
    EXPECT_THAT(fault_of(old),
                AllOf(HasSubstr("can0"), HasSubstr("refuses"), HasSubstr("Protocol not available")));
    EXPECT_EQ(old.kernel.open_descriptors(), 0u);
  }
}

TEST(SocketCanBus, RefusesAConfigurationThatCannotBe) {
  const auto fault = [](SocketCanConfig config) {
    Bench bench(std::move(config));
    return fault_of(bench);
  };
  EXPECT_THAT(fault({.interface = ""}), HasSubstr("no name of an interface"));
  EXPECT_THAT(fault({.interface = "sixteenletters16"}), HasSubstr("no name of an interface"));
  EXPECT_THAT(fault({.interface = "can/0"}), HasSubstr("no name of an interface"));
  EXPECT_THAT(fault({.identifiers = {0x800}}), HasSubstr("0x800"));
  EXPECT_THAT(fault({.identifiers = std::vector<std::uint32_t>(513, 1)}), HasSubstr("513"));
}

}  // namespace
}  // namespace headway::drivers
