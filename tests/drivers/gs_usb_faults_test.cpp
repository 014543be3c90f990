// The bus while its adapter, its cable or the bus behind it does not behave.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include "drivers/gs_usb_bus.h"
#include "hal/error.h"
#include "tests/drivers/gs_usb_bench.h"
#include "tests/drivers/noise.h"

namespace headway::drivers {
namespace {

using hal::CanBusState;
using std::chrono::milliseconds;
using testing::ScriptedUsb;

/// While it lives, the leak checker takes no note of what is allocated.
struct LeakOnPurpose {
#ifdef __SANITIZE_ADDRESS__
  LeakOnPurpose() { __lsan_disable(); }
  ~LeakOnPurpose() { __lsan_enable(); }
#else
  LeakOnPurpose() {}
#endif
};

class GsUsbFaults : public testing::GsUsbBench {};

// --- an adapter that does not do as it should ---

TEST_F(GsUsbFaults, AnAdapterThatRefusesOrCutsShortAnAnswerIsNotOpened) {
  for (const std::uint8_t request :
       {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{4}, std::uint8_t{5}}) {
    adapter.refuses = request;
    EXPECT_THROW(open(), Error) << static_cast<int>(request);
    adapter.refuses.reset();
    adapter.cuts_short = request;
    if (request >= 4) {
      EXPECT_THROW(open(), Error) << static_cast<int>(request);
    }
    adapter.cuts_short.reset();
    EXPECT_EQ(usb.held(), ScriptedUsb::Held{});
  }
  open();
  EXPECT_TRUE(works());
}

TEST_F(GsUsbFaults, AnAdapterThatNobodyHadClosedIsTakenOverWithoutTheFramesLeftInIt) {
  adapter.seen.is_started = true;
  for (int i = 0; i < 20; ++i) adapter.receive(0x100);
  open();
  serve();
  EXPECT_TRUE(received().empty());
  EXPECT_TRUE(works());
}

TEST_F(GsUsbFaults, AMuteAdapterIsGivenUpAfterOneUnansweredRequest) {
  adapter.is_mute = true;
  const Time begin = clock.now();
  EXPECT_THROW(open(), Error);
  EXPECT_LE(clock.now() - begin, GsUsbAdapter::kAnswerTimeout + milliseconds(10));
}

TEST_F(GsUsbFaults, AnAdapterThatFallsMuteIsLostWithinSeconds) {
  open();
  serve(2);
  adapter.is_mute = true;
  serve(5);
  EXPECT_EQ(bus->state(), CanBusState::kGone);
  adapter.is_mute = false;
  serve(6);
  EXPECT_TRUE(works());
}

TEST_F(GsUsbFaults, ALateAnswerMakesNoFrameOlderOrYoungerThanItIs) {
  open();
  adapter.answer_takes = milliseconds(400);
  adapter.receive(0x100);
  const Time on_the_bus = clock.now();
  serve(3);
  const auto frames = received();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_LT(std::chrono::abs(frames[0].stamp - on_the_bus), milliseconds(1));
  EXPECT_EQ(bus->state(), CanBusState::kErrorActive) << "late is not lost";
}

TEST_F(GsUsbFaults, AClockThatJumpsIsNotBelieved) {
  open();
  serve(1.5);
  for (const std::uint32_t jump :
       {1'000'000'000u, 0u - 2'000'000'000u}) {  // a quarter of an hour on, half of one back
    adapter.us_at_start += jump;
    adapter.receive(0x100);
    const Time on_the_bus = clock.now();
    serve();
    EXPECT_LT(std::chrono::abs(received().at(0).stamp - on_the_bus), milliseconds(1));
  }
}

TEST_F(GsUsbFaults, ASignalIsNoFault) {
  open();
  usb.interruptions = 3;
  serve();
  EXPECT_TRUE(works());
  EXPECT_EQ(bus->stats().gone, 0u);
}

TEST_F(GsUsbFaults, ReadsThatBreakEndTheConnectionAndTheNextIsGood) {
  open();
  serve(6);
  adapter.breaks_reads = 1;
  serve(0.1);
  EXPECT_EQ(bus->stats().gone, 1u);
  EXPECT_TRUE(works()) << "a connection that was good is opened again at once";
}

TEST_F(GsUsbFaults, AStalledReadIsClearedAndTheControllerStartedAnew) {
  open();
  serve(1);
  const int starts = adapter.seen.starts;
  adapter.stalls_reads = 5;
  serve(0.02);
  EXPECT_EQ(adapter.seen.halts_cleared, 2) << "of both endpoints";
  EXPECT_EQ(adapter.seen.starts, starts + 1);
  EXPECT_EQ(bus->stats().gone, 0u) << "it was there all the time";
  EXPECT_TRUE(works());
}

TEST_F(GsUsbFaults, AFrameWhoseWriteStallsIsGivenUp) {
  open();
  serve(1);
  adapter.stalls_writes = 1;
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(bus->send(frame(0x100)));
  serve(0.05);
  EXPECT_EQ(bus->stats().sent, 2u);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(bus->send(frame(0x100)));
  serve();
  EXPECT_EQ(bus->stats().sent, 12u);
}

TEST_F(GsUsbFaults, AnEndpointThatStallsForEverIsClearedTenTimesASecondOnly) {
  open();
  adapter.stalls_reads = 1'000'000;
  serve(2);
  EXPECT_NEAR(adapter.seen.halts_cleared, 2 * 20, 6);
}

TEST_F(GsUsbFaults, TransfersThatNeverComeBackDoNotHoldAnybodyForLong) {
  {
    const LeakOnPurpose kept;
    open();
  }
  adapter.keeps_reads = true;
  const Time begin = clock.now();
  bus.reset();
  EXPECT_LT(clock.now() - begin, std::chrono::seconds(3));
  EXPECT_FALSE(adapter.seen.is_started);
  // The kernel's memory stays: that is what this is about.
  EXPECT_GT(usb.held().under_way, 0);
  usb.forget();
}

TEST_F(GsUsbFaults, WhatIsNoFrameOfTheChannelIsCountedAndNotHandedOn) {
  open();
  std::uint64_t unusable = 0;
  for (const std::size_t size : {0u, 1u, 19u, 21u, 23u, 25u, 64u, 512u, 600u}) {
    adapter.outbox.push_back(testing::ScriptedAdapter::Bytes(size, 0xFF));
    serve();
    EXPECT_EQ(bus->stats().unusable, ++unusable) << size << " bytes";
  }
  adapter.hand_over(0xFFFFFFFF, 0x100, {}, 8, 1);  // a channel that it does not have
  adapter.receive(0x80000100);                     // an extended identifier
  adapter.receive(0x40000100);                     // a remote frame
  adapter.receive(0x00000800);                     // no identifier of 11 bits
  serve();
  EXPECT_EQ(bus->stats().unusable, unusable + 4);
  EXPECT_TRUE(received().empty());
  EXPECT_TRUE(works());
}

TEST_F(GsUsbFaults, EchoesOfNothingFreeNothing) {
  open();
  adapter.echoes = false;
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(bus->send(frame(0x100)));
  serve();
  for (const std::uint32_t id : {9u, 10u, 4711u, 0xFFFFFFFEu}) adapter.echo(id);
  adapter.echo(3);
  adapter.echo(3);
  serve();
  EXPECT_EQ(bus->stats().unusable, 5u);
  EXPECT_EQ(bus->stats().sent, 1u);
  EXPECT_TRUE(bus->send(frame(0x100)) && bus->send(frame(0x100)));
  EXPECT_FALSE(bus->send(frame(0x100)));
}

TEST_F(GsUsbFaults, AnOverflowIsCountedAsALoss) {
  open();
  adapter.hand_over(0xFFFFFFFF, 0x100, {}, 8, 0, 1);
  adapter.report(0x01, 0, 0);  // told by an error frame
  serve();
  EXPECT_EQ(bus->stats().lost, 2u);
  EXPECT_EQ(received().size(), 1u) << "the frame that carries the flag is good";
}

TEST_F(GsUsbFaults, FramesThatTheBusLoopDoesNotTakeAreCountedAsLost) {
  open();
  for (std::size_t i = 0; i < CanMailbox::kIncoming + 7; ++i) adapter.receive(0x100);
  serve(0.1);
  EXPECT_EQ(bus->stats().lost, 7u);
  EXPECT_EQ(received().size(), CanMailbox::kIncoming);
  EXPECT_TRUE(works());
}

// --- trouble on the bus ---

TEST_F(GsUsbFaults, TellsHowTheControllerFares) {
  open();
  const auto state_after = [&](std::uint8_t controller, std::uint8_t transmit, std::uint8_t receive) {
    adapter.report(controller, transmit, receive);
    serve(0.001);
    EXPECT_EQ(bus->stats().transmit_errors, transmit);
    EXPECT_EQ(bus->stats().receive_errors, receive);
    return bus->state();
  };
  EXPECT_EQ(state_after(0x08, 96, 3), CanBusState::kErrorWarning);
  EXPECT_EQ(state_after(0x04, 4, 100), CanBusState::kErrorWarning);
  EXPECT_EQ(state_after(0x20, 128, 3), CanBusState::kErrorPassive);
  EXPECT_EQ(state_after(0x10, 4, 127), CanBusState::kErrorPassive);
  EXPECT_EQ(state_after(0x40, 0, 0), CanBusState::kErrorActive);
  EXPECT_EQ(bus->stats().unusable, 0u);
  EXPECT_TRUE(received().empty()) << "an error frame is no frame of the bus";
}

TEST_F(GsUsbFaults, AsksTheControllerHowItFares) {
  open();
  adapter.state = {2, 5, 130};  // error passive; receive, transmit errors
  serve(1.1);
  EXPECT_EQ(bus->state(), CanBusState::kErrorPassive);
  EXPECT_EQ(bus->stats().receive_errors, 5);
  EXPECT_EQ(bus->stats().transmit_errors, 130);
}

TEST_F(GsUsbFaults, ABusThatIsOffIsStartedAnew) {
  open();
  serve(1);
  const int starts = adapter.seen.starts;
  adapter.report_bus_off();
  serve(0.001);
  EXPECT_EQ(bus->state(), CanBusState::kBusOff);
  EXPECT_EQ(bus->stats().bus_off, 1u);
  serve(0.05);
  EXPECT_EQ(adapter.seen.starts, starts) << "not in haste";
  serve(0.1);
  EXPECT_EQ(adapter.seen.starts, starts + 1);
  EXPECT_EQ(bus->state(), CanBusState::kErrorActive);
  EXPECT_EQ(bus->stats().gone, 0u);
  EXPECT_TRUE(works());
}

TEST_F(GsUsbFaults, FramesThatAreNeverOnTheBusAreGivenUpAfterATenthOfASecond) {
  open();
  serve(1);
  adapter.echoes = false;
  const int starts = adapter.seen.starts;
  ASSERT_TRUE(bus->send(frame(0x100)));
  serve(0.09);
  EXPECT_EQ(adapter.seen.starts, starts);
  serve(0.03);
  EXPECT_EQ(adapter.seen.starts, starts + 1);
  EXPECT_EQ(bus->state(), CanBusState::kBusOff);
  EXPECT_EQ(bus->stats().sent, 0u);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(bus->send(frame(0x100))) << "its place is free again";
  EXPECT_FALSE(bus->send(frame(0x100)));
  adapter.echoes = true;
  serve();
  EXPECT_EQ(bus->stats().sent, 10u);
  EXPECT_EQ(bus->state(), CanBusState::kErrorActive) << "for an echo has come";
  EXPECT_EQ(bus->stats().bus_off, 1u);
}

TEST_F(GsUsbFaults, AnAdapterIsNotBlamedForAThreadThatWasHeldUp) {
  open();
  serve(1);
  adapter.echoes = false;
  const int starts = adapter.seen.starts;
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(bus->send(frame(0x100)));
  serve(0.05);
  for (std::uint32_t id = 0; id < 10; ++id) adapter.echo(id);
  clock.advance(std::chrono::seconds(10));
  serve();
  EXPECT_EQ(bus->stats().sent, 10u);
  EXPECT_EQ(adapter.seen.starts, starts);
}

TEST_F(GsUsbFaults, WhileNobodyAcknowledgesTheControllerIsStartedTenTimesASecond) {
  open();
  serve(1);
  adapter.echoes = false;
  const int starts = adapter.seen.starts;
  for (int i = 0; i < 2000; ++i) {
    adapter.state = {2, 0, 128};  // error passive, as a controller that stands alone
    bus->send(frame(0x100));
    serve();
    if (i >= 22) {
      ASSERT_EQ(bus->state(), CanBusState::kBusOff) << i;
    }
  }
  EXPECT_EQ(bus->stats().bus_off, 1u);
  EXPECT_NEAR(adapter.seen.starts - starts, 100, 20);
  EXPECT_EQ(bus->stats().gone, 0u);
  EXPECT_GT(bus->stats().refused, 100u);
  adapter.echoes = true;
  serve(0.2);
  EXPECT_TRUE(works());
}

RC_GTEST_FIXTURE_PROP(GsUsbFaults, NoFrameIsSentLateHoweverLongTheAdapterTakes, ()) {
  open();
  serve(1);
  testing::Noise noise(*rc::gen::inRange(1u, 1u << 30));
  // The bus loop goes on meanwhile. A frame says when it was meant to be on the bus.
  std::vector<Time> meant;
  usb.as_time_passes = [&] {
    if (!bus || meant.size() > 0xFFFF) return;
    hal::CanFrame next = frame(0x100);
    next.data = {static_cast<std::uint8_t>(meant.size()), static_cast<std::uint8_t>(meant.size() >> 8)};
    if (bus->send(next)) meant.push_back(clock.now());
  };
  for (int i = 0; i < 20; ++i) {
    adapter.answer_takes = noise.percent() < 50 ? milliseconds(noise.below(490)) : milliseconds(0);
    adapter.echoes = noise.percent() < 70;
    if (noise.percent() < 20) adapter.stalls_writes = 1;
    if (noise.percent() < 20) adapter.report_bus_off();
    serve(0.01 * (noise.percent() + 1));
  }
  usb.as_time_passes = nullptr;
  RC_ASSERT(adapter.seen.sent.size() > 10u);
  for (const hal::CanFrame& sent : adapter.seen.sent) {
    const std::size_t number = sent.data[0] + 256u * sent.data[1];
    RC_ASSERT(sent.stamp - meant.at(number) <= milliseconds(120));
  }
}

TEST_F(GsUsbFaults, AnEchoThatComesAfterItsFrameWasGivenUpIsCountedOnly) {
  open();
  serve(1);
  adapter.echoes = false;
  ASSERT_TRUE(bus->send(frame(0x100)));
  serve(0.2);
  adapter.echo(0);
  serve();
  EXPECT_EQ(bus->stats().unusable, 1u);
  EXPECT_EQ(bus->stats().sent, 0u);
}

TEST_F(GsUsbFaults, AWriteThatTheAdapterDoesNotTakeIsCalledBack) {
  open();
  serve(1);
  adapter.keeps_writes = true;
  ASSERT_TRUE(bus->send(frame(0x100)));
  serve(0.05);
  adapter.keeps_writes = false;
  unplug();
  serve(0.02);
  EXPECT_EQ(bus->state(), CanBusState::kGone);
}

}  // namespace
}  // namespace headway::drivers
