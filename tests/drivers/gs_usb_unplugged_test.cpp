// The bus while its adapter is pulled out and plugged in, in the middle of whatever it does.
#include <array>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "drivers/gs_usb_bus.h"
#include "hal/error.h"
#include "tests/drivers/gs_usb_bench.h"

namespace headway::drivers {
namespace {

using hal::CanBusState;
using ::testing::HasSubstr;
using testing::ScriptedUsb;

class GsUsbUnplugged : public testing::GsUsbBench {};

TEST_F(GsUsbUnplugged, AnUnpluggedAdapterIsGoneAtOnceAndBackWhenPluggedInAgain) {
  open();
  adapter.echoes = false;
  for (int i = 0; i < 10; ++i) bus->send(frame(0x100));
  serve();  // so that writes and reads are under way
  adapter.receive(0x321);
  unplug();
  serve();
  EXPECT_EQ(bus->state(), CanBusState::kGone);
  EXPECT_EQ(bus->stats().gone, 1u);
  EXPECT_FALSE(bus->send(frame(0x100)));
  EXPECT_EQ(usb.held(), ScriptedUsb::Held{}) << "nothing of it is kept";

  adapter.echoes = true;
  const std::size_t sent_before = adapter.seen.sent.size();
  usb.plug(adapter);  // by the bus a new device, with the same serial number
  serve(5.1);
  EXPECT_EQ(bus->state(), CanBusState::kErrorActive);
  EXPECT_EQ(adapter.seen.sent.size(), sent_before) << "what waited then would be late now";
  EXPECT_TRUE(works());
}

TEST_F(GsUsbUnplugged, FramesThatWaitedWhenItWasUnpluggedAreNotSentLate) {
  open();
  usb.while_waiting = [&] {
    for (int i = 0; i < 10; ++i) bus->send(frame(0x100));
    unplug();
  };
  serve();
  ASSERT_EQ(bus->state(), CanBusState::kGone);
  usb.plug(adapter);
  serve(5.1);
  EXPECT_TRUE(adapter.seen.sent.empty());
  EXPECT_EQ(bus->stats().sent, 0u);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(bus->send(frame(0x100))) << "there is room again, " << i;
}

TEST_F(GsUsbUnplugged, ItIsLookedForAfterPausesThatDoubleUpToFiveSeconds) {
  const std::vector<double> expected{0, 0.5, 1, 2, 4, 5, 5, 5, 5};  // the first at once
  open();
  for (std::uint64_t round = 1; round <= 2; ++round) {
    serve(10);
    unplug();
    usb.searches.clear();
    Time last = clock.now();
    serve(30);
    ASSERT_EQ(usb.searches.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(to_seconds(usb.searches[i] - last), expected[i], 0.02) << "pause " << i;
      last = usb.searches[i];
    }
    EXPECT_EQ(bus->stats().gone, round) << "lost once, however often it is looked for";
    usb.plug(adapter);
  }
}

TEST_F(GsUsbUnplugged, AnAdapterThatBreaksAgainAndAgainIsNotReopenedInHaste) {
  open();
  usb.searches.clear();
  for (int i = 0; i < 2000; ++i) {
    adapter.breaks_reads = 1;
    serve(0.01);
  }
  EXPECT_LE(usb.searches.size(), 8u);
  EXPECT_GE(usb.searches.size(), 4u);
}

TEST_F(GsUsbUnplugged, AnotherAdapterInItsPlaceIsNotTaken) {
  open();
  testing::ScriptedAdapter other(clock, "0099");
  unplug();
  usb.plug(other);
  serve(12);
  EXPECT_EQ(bus->state(), CanBusState::kGone);
  EXPECT_TRUE(other.seen.requests.empty());
  usb.plug(adapter);
  serve(5.1);
  EXPECT_TRUE(works());
  bus.reset();
}

TEST_F(GsUsbUnplugged, UnpluggedAtAnyCallOfAnOpeningLeavesNothingBehind) {
  int openings = 0;
  for (int call = 1; openings < 3; ++call) {
    ASSERT_LT(call, 300);
    usb.plug(adapter);
    usb.calls_until_unplugged = call;
    was_unplugged = true;
    try {
      open();
      ++openings;  // it was open before the last call came
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("0031"));
    }
    bus.reset();
    ASSERT_EQ(usb.held(), ScriptedUsb::Held{}) << "unplugged at call " << call;
    usb.calls_until_unplugged = -1;
    usb.unplug(adapter);
  }
}

TEST_F(GsUsbUnplugged, TenThousandTimesUnpluggedAndOpenedNothingLeaks) {
  was_unplugged = true;
  open();
  ScriptedUsb::Held while_open = usb.held();
  for (int i = 0; i < 10'000; ++i) {
    if (i % 10 == 0) {  // closed and opened by its owner
      bus.reset();
      ASSERT_EQ(usb.held(), ScriptedUsb::Held{});
      open();
    } else {
      adapter.replies = i % 3 == 0;
      for (int k = 0; k < i % 7; ++k) bus->send(frame(0x100));
      if (i % 2 == 0) serve(0.001);
      usb.unplug(adapter);
      serve(0.02);
      ASSERT_EQ(bus->state(), CanBusState::kGone);
      usb.plug(adapter);
      clock.advance(std::chrono::seconds(5));
      serve(0.02);
    }
    ASSERT_EQ(bus->state(), CanBusState::kErrorActive) << i;
    ASSERT_EQ(usb.held(), while_open) << i;
  }
  EXPECT_TRUE(works());
}

RC_GTEST_FIXTURE_PROP(GsUsbUnplugged, WhateverHappensItWorksOnceAllIsWellAgain, ()) {
  was_unplugged = true;
  open();
  const auto deeds = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 16));
  for (const int deed : deeds) {
    switch (deed) {
      case 0:
        usb.unplug(adapter);
        break;
      case 1:
        usb.unplug(adapter);
        usb.plug(adapter);
        break;
      case 2:
        adapter.stalls_reads = 3;
        break;
      case 3:
        adapter.stalls_writes = 1;
        break;
      case 4:
        adapter.breaks_reads = 1;
        break;
      case 5:
        adapter.echoes = !adapter.echoes;
        break;
      case 6:
        adapter.report_bus_off();
        break;
      case 7:
        adapter.echo(static_cast<std::uint32_t>(deeds.size() % 12));
        break;
      case 8:
        adapter.outbox.emplace_back(deeds.size() % 40);
        break;
      case 9:
        adapter.is_mute = !adapter.is_mute;
        break;
      case 10:
        usb.calls_until_unplugged = static_cast<int>(deeds.size());
        break;
      case 11:
        serve(1.3);
        break;
      case 12:
        bus->send(frame(0x100));
        break;
      default:
        for (int i = 0; i < 4; ++i) bus->send(frame(0x100));
        serve(0.004);
    }
    serve(0.003);
  }
  usb.calls_until_unplugged = -1;
  adapter.stalls_reads = adapter.stalls_writes = adapter.breaks_reads = 0;
  adapter.echoes = true;
  adapter.is_mute = false;
  usb.unplug(adapter);
  usb.plug(adapter);
  serve(12);
  RC_ASSERT(bus->state() == CanBusState::kErrorActive);
  received();
  RC_ASSERT(works());
  for (int i = 0; i < 10; ++i) RC_ASSERT(bus->send(frame(0x100)));
  RC_ASSERT(!bus->send(frame(0x100)));
  bus.reset();
  RC_ASSERT(usb.held() == ScriptedUsb::Held{});
}

}  // namespace
}  // namespace headway::drivers
