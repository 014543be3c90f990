// The bus while its adapter behaves.
#include "drivers/gs_usb_bus.h"

#include <array>
#include <atomic>
#include <string>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/drivers/gs_usb_bench.h"
#include "tests/heap_count.h"

namespace headway::drivers {
namespace {

using hal::CanBusState;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class GsUsb : public testing::GsUsbBench {
 protected:
  std::string fault_of(const GsUsbConfig& config) {
    try {
      open(config);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }
};

TEST_F(GsUsb, SetsTheAdapterUpAsTheKernelDoesAndStartsItLast) {
  open();
  std::vector<std::pair<int, int>> told;
  for (const auto& r : adapter.seen.requests) told.emplace_back(r.number, r.value);
  // Host format, device config, bit timing limits, mode reset, bit timing, mode start; then its clock and its
  // state.
  EXPECT_THAT(told, ElementsAre(std::pair(0, 1), std::pair(5, 1), std::pair(4, 0), std::pair(2, 0),
                                std::pair(1, 0), std::pair(2, 0), std::pair(6, 0), std::pair(14, 0)));
  EXPECT_EQ(adapter.seen.resets, 1);
  EXPECT_TRUE(adapter.seen.is_started);
  EXPECT_EQ(adapter.seen.timing, (std::array<std::uint32_t, 5>{6, 7, 2, 1, 6}));
  EXPECT_EQ(adapter.seen.mode_flags, 1u << 4);
}

TEST_F(GsUsb, ResetsTheControllerWhenItCloses) {
  open();
  bus.reset();
  EXPECT_FALSE(adapter.seen.is_started);
  EXPECT_EQ(adapter.seen.resets, 2);
}

TEST_F(GsUsb, CountsAFrameAsSentOnceItIsOnTheBus) {
  open();
  adapter.echoes = false;
  ASSERT_TRUE(bus->send({.id = 0x211, .dlc = 3, .data = {1, 2, 3}, .stamp = {}}));
  serve();
  ASSERT_EQ(adapter.seen.sent.size(), 1u);
  EXPECT_EQ(adapter.seen.sent[0].id, 0x211u);
  EXPECT_EQ(adapter.seen.sent[0].dlc, 3);
  EXPECT_THAT(adapter.seen.sent[0].data, ElementsAre(1, 2, 3, 0, 0, 0, 0, 0));
  EXPECT_EQ(bus->stats().sent, 0u);
  adapter.echo(adapter.seen.echo_ids[0]);
  serve();
  EXPECT_EQ(bus->stats().sent, 1u);
  EXPECT_TRUE(received().empty()) << "an echo is no frame of others";
}

TEST_F(GsUsb, AFrameThatIsHandedOverWhileItWaitsGoesOutAtOnce) {
  open();
  Time handed_over{};
  usb.while_waiting = [&] {
    handed_over = clock.now();
    bus->send(frame(0x100));
  };
  serve(0.1);
  ASSERT_EQ(adapter.seen.sent.size(), 1u);
  EXPECT_LT(adapter.seen.sent[0].stamp - handed_over, microseconds(100));
}

TEST_F(GsUsb, HandsOverWhatComesIn) {
  open();
  adapter.receive(0x7FF, {9, 8, 7}, 3);
  adapter.receive(0, {}, 15);
  serve();
  const auto frames = received();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].id, 0x7FFu);
  EXPECT_EQ(frames[0].dlc, 3);
  EXPECT_EQ(frames[0].data[2], 7);
  EXPECT_EQ(frames[1].dlc, 8) << "a length code above 8 means 8 bytes";
  EXPECT_EQ(bus->stats().received, 2u);
}

TEST_F(GsUsb, RefusesTheEleventhFrameUntilOneIsOnTheBus) {
  open();
  adapter.echoes = false;
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(bus->send(frame(0x100)));
  EXPECT_FALSE(bus->send(frame(0x100)));
  serve();
  EXPECT_EQ(adapter.seen.sent.size(), 10u);
  EXPECT_FALSE(bus->send(frame(0x100)));
  EXPECT_EQ(bus->stats().refused, 2u);
  adapter.echo(7);
  serve();
  EXPECT_TRUE(bus->send(frame(0x100)));
  EXPECT_FALSE(bus->send(frame(0x100)));
  serve();
  EXPECT_EQ(adapter.seen.echo_ids.back(), 7u) << "the slot that is free";
}

TEST_F(GsUsb, RefusesWhatIsNoClassicFrame) {
  open();
  EXPECT_FALSE(bus->send({.id = 0x800, .dlc = 8, .data = {}, .stamp = {}}));
  EXPECT_FALSE(bus->send({.id = 0x100, .dlc = 9, .data = {}, .stamp = {}}));
  EXPECT_EQ(bus->stats().refused, 2u);
}

TEST_F(GsUsb, TakesInterfaceAndEndpointsFromTheDescriptor) {
  adapter.interface = 1;
  adapter.endpoint_in = 0x83;
  adapter.endpoint_out = 0x04;
  open();
  EXPECT_TRUE(works());
}

TEST_F(GsUsb, UsesTheChannelThatItIsTold) {
  adapter.channels = 2;
  open({.serial = "0031", .channel = 1});
  EXPECT_EQ(adapter.seen.requests[2].value, 1);
  adapter.hand_over(0xFFFFFFFF, 0x100, {}, 8, 0);
  adapter.hand_over(0xFFFFFFFF, 0x200, {}, 8, 1);
  serve();
  const auto frames = received();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].id, 0x200u);
  EXPECT_EQ(bus->stats().unusable, 1u);
}

TEST_F(GsUsb, TakesEveryProductThatSpeaksItsProtocol) {
  for (const auto& [vendor, product] :
       {std::pair(0x1D50, 0x606F), {0x1209, 0x2323}, {0x1CD2, 0x606F}, {0x16D0, 0x10B8}}) {
    adapter.vendor = static_cast<std::uint16_t>(vendor);
    adapter.product = static_cast<std::uint16_t>(product);
    open();
    EXPECT_TRUE(works());
    bus.reset();
  }
}

// --- time ---

TEST_F(GsUsb, StampsFramesByTheAdaptersClockThroughItsWrap) {
  // Just before the wrap, and off by as much as two poor crystals are.
  adapter.clock_rate = 1.0001;
  adapter.us_at_start = 0u - adapter.us_at(clock.now()) - 3'000'000u;
  open();
  std::uint32_t last_us = 0;
  bool has_wrapped = false;
  for (int i = 0; i < 1000; ++i) {
    const Time on_the_bus = clock.now();
    const std::uint32_t us = adapter.us_at(on_the_bus);
    has_wrapped = has_wrapped || us < last_us;
    last_us = us;
    adapter.receive(0x100);
    clock.advance(milliseconds(4));  // it lies about before anybody asks
    serve();
    const auto frames = received();
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_LT(std::chrono::abs(frames[0].stamp - on_the_bus), microseconds(300)) << "frame " << i;
  }
  EXPECT_TRUE(has_wrapped);
}

TEST_F(GsUsb, StampsFramesForHoursAndKeepsTheirOrder) {
  adapter.clock_rate = 0.9999;
  open();
  Time last{};
  for (int i = 0; i < 3 * 3600; ++i) {
    const Time on_the_bus = clock.now();
    adapter.receive(0x100);
    clock.advance(milliseconds(2));
    serve(0.003);
    clock.advance(milliseconds(995));
    const auto frames = received();
    ASSERT_EQ(frames.size(), 1u);
    ASSERT_LT(std::chrono::abs(frames[0].stamp - on_the_bus), microseconds(600)) << "second " << i;
    ASSERT_GE(frames[0].stamp, last);
    last = frames[0].stamp;
  }
}

TEST_F(GsUsb, StampsNoFrameEarlierThanTheOneBefore) {
  open();
  adapter.receive(0x100);
  adapter.us_at_start -= 500;
  adapter.receive(0x101);
  serve();
  const auto frames = received();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].stamp, frames[0].stamp);
}

TEST_F(GsUsb, StampsFramesOnArrivalWhereTheAdapterHasNoClock) {
  adapter.features = 0;
  open();
  EXPECT_EQ(adapter.seen.mode_flags, 0u);
  adapter.receive(0x100);
  clock.advance(milliseconds(3));
  const Time before = clock.now();
  serve();
  EXPECT_GE(received().at(0).stamp, before);
}

TEST_F(GsUsb, StampsFramesOnArrivalWhereTheClockCannotBeAsked) {
  adapter.refuses = 6;
  open();
  adapter.receive(0x100);
  clock.advance(milliseconds(3));
  const Time before = clock.now();
  serve();
  EXPECT_GE(received().at(0).stamp, before);
  adapter.state = {1, 0, 100};
  serve(10);
  EXPECT_EQ(bus->state(), CanBusState::kErrorWarning) << "its state can be";
  EXPECT_EQ(bus->stats().gone, 0u) << "firmware without the request is no broken adapter";
}

TEST_F(GsUsb, NeedsNoAdapterThatTellsItsState) {
  adapter.refuses = 14;
  open();
  serve(10);
  EXPECT_EQ(bus->stats().gone, 0u);
  EXPECT_TRUE(works());
}

// --- which adapter ---

TEST_F(GsUsb, FindsTheAdapterByItsSerialNumberAmongOthers) {
  testing::ScriptedAdapter other(clock, "0032"), camera(clock, "0031");
  camera.product = 0x1234;
  usb.plug(other);
  usb.plug(camera);
  open({.serial = "0032"});
  EXPECT_TRUE(other.seen.is_started);
  EXPECT_TRUE(adapter.seen.requests.empty() && camera.seen.requests.empty()) << "others are left alone";
  bus.reset();
}

TEST_F(GsUsb, SaysWhichAdaptersThereAreWhenNoneHasTheSerialNumber) {
  testing::ScriptedAdapter other(clock, "0032");
  usb.plug(other);
  EXPECT_THAT(fault_of({.serial = "0033"}),
              HasSubstr("'0033': is not there, expected it among the candleLight-type "
                        "adapters plugged in: '0031', '0032'"));
  EXPECT_THROW(open({.serial = "0033"}), InputError) << "as of every other device that is not there";
}

TEST_F(GsUsb, NeedsNoSerialNumberWhileThereIsOneAdapterOnly) {
  open({});
  EXPECT_TRUE(works());
  bus.reset();
  testing::ScriptedAdapter other(clock, "0032");
  usb.plug(other);
  EXPECT_THAT(fault_of({}), HasSubstr("'0031', '0032' fit serial '', expected one"));
}

TEST_F(GsUsb, SaysWhatToDoAboutAnAdapterThatItCannotOpen) {
  adapter.is_denied = true;
  EXPECT_THAT(fault_of({.serial = "0031"}), HasSubstr("install config/udev/60-headway.rules"));
  adapter.is_denied = false;
  adapter.is_claimed = true;
  EXPECT_THAT(fault_of({.serial = "0031"}), HasSubstr("another program uses it"));
  adapter.is_claimed = false;
  adapter.has_bulk = false;
  EXPECT_THAT(fault_of({.serial = "0031"}), HasSubstr("no bulk endpoints"));
  adapter.has_bulk = true;
  EXPECT_THAT(fault_of({.serial = "0031", .channel = 1}), HasSubstr("channel: 1, expected 0 to 0"));
  adapter.clock_hz = 1'000'000;
  EXPECT_THAT(fault_of({.serial = "0031"}),
              HasSubstr("500000 bit/s cannot be made of its clock of 1000000 Hz"));
  usb.unplug(adapter);
  EXPECT_THAT(fault_of({.serial = "0031"}), HasSubstr("plugged in: none"));
  usb.fails_to_start = true;
  EXPECT_THAT(fault_of({.serial = "0031"}), HasSubstr("libusb does not start"));
}

TEST_F(GsUsb, NeedsMemoryForItsTransfers) {
  usb.has_no_memory = true;
  EXPECT_THAT(fault_of({.serial = "0031"}), HasSubstr("no memory"));
}

TEST_F(GsUsb, RefusesConfigurationsThatNoBusCouldWorkWith) {
  for (const GsUsbConfig& config :
       {GsUsbConfig{.channel = 256}, GsUsbConfig{.bitrate = 0}, GsUsbConfig{.bitrate = 2'000'000},
        GsUsbConfig{.sample_point = 0.2}, GsUsbConfig{.sample_point = 1}, GsUsbConfig{.echo_timeout = {}},
        GsUsbConfig{.retry = {.first = {}}}, GsUsbConfig{.retry = {.longest = milliseconds(100)}}}) {
    EXPECT_THROW(config.validate(), InputError);
    EXPECT_THROW(open(config), InputError);
  }
  EXPECT_NO_THROW(GsUsbConfig{}.validate());
}

// --- many frames ---

TEST_F(GsUsb, LosesAndReordersNoneOfAHundredThousandFrames) {
  constexpr std::uint32_t kFrames = 100'000;
  open();
  adapter.replies = true;
  std::uint32_t sent = 0, came = 0;
  int idle = 0;
  std::array<hal::CanFrame, 64> some;
  while (came < kFrames) {
    for (; sent < kFrames; ++sent) {
      hal::CanFrame f = frame(sent % 0x7FF);
      for (unsigned i = 0; i < 4; ++i) f.data[i] = static_cast<std::uint8_t>(sent >> (8 * i));
      if (!bus->send(f)) break;
    }
    bus->serve(microseconds(200));
    const std::size_t n = bus->receive(some);
    ASSERT_LT(idle += n == 0, 1000);
    for (std::size_t i = 0; i < n; ++i, ++came) {
      std::uint32_t number = 0;
      for (unsigned k = 4; k-- > 0;) number = number << 8 | some[i].data[k];
      ASSERT_EQ(number, came);
      ASSERT_EQ(some[i].id, came % 0x7FF + 1);
    }
  }
  EXPECT_EQ(bus->stats().sent, kFrames);
  EXPECT_EQ(bus->stats().received, kFrames);
  EXPECT_EQ(bus->stats().lost + bus->stats().unusable + bus->stats().gone, 0u);
}

TEST_F(GsUsb, UsesNoHeapInTheBusLoop) {
  open();
  adapter.replies = true;
  std::uint64_t allocations = 0;
  std::array<hal::CanFrame, 16> some;
  std::size_t came = 0;
  for (int i = 0; i < 2000; ++i) {
    if (i == 1000) unplug();
    if (i == 1500) usb.plug(adapter);
    const std::uint64_t before = heap_allocations();
    for (int k = 0; k < 12; ++k) bus->send(frame(0x100));
    came += bus->receive(some);
    static_cast<void>(bus->state());
    static_cast<void>(bus->stats());
    allocations += heap_allocations() - before;
    serve();
  }
  EXPECT_EQ(allocations, 0u);
  EXPECT_GT(came, 12'000u);
  EXPECT_TRUE(works()) << "it has come back";
}

TEST_F(GsUsb, ServesTheBusLoopFromAnotherThread) {
  constexpr std::uint32_t kFrames = 20'000;
  open();
  adapter.replies = true;
  usb.waits_truly = true;
  std::atomic<bool> stop{false};
  std::thread server([&] {
    while (!stop.load()) serve(0.001);
  });
  std::uint32_t sent = 0, came = 0, wrong = 0;
  std::array<hal::CanFrame, 64> some;
  while (came < kFrames && bus->state() != CanBusState::kGone) {
    while (sent < kFrames && bus->send(frame(sent % 0x7FF))) ++sent;
    const std::size_t n = bus->receive(some);
    for (std::size_t i = 0; i < n; ++i, ++came) wrong += some[i].id != came % 0x7FF + 1;
    if (n == 0) std::this_thread::yield();
  }
  stop = true;
  server.join();
  EXPECT_EQ(came, kFrames);
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(bus->stats().sent, kFrames);
}

}  // namespace
}  // namespace headway::drivers
