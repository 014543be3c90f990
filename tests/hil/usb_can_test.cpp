// GsUsbBus on libusb and a real kernel. The adapter's serial number stands in HEADWAY_USB_CAN; on its bus one
// node answers every frame with the same data under the next identifier. Commands to an emulated adapter go
// line by line into the pipe HEADWAY_USB_CAN_COMMANDS; without it, the tests that need them are skipped.
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "drivers/gs_usb_bus.h"
#include "hal/clock.h"
#include "hal/error.h"
#include "tests/held.h"

namespace headway::drivers {
namespace {

using hal::CanBusState;
using std::chrono::milliseconds;

constexpr Duration kPatience = std::chrono::seconds(60);  ///< an emulated machine stands still now and then

class UsbCan : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* serial = std::getenv("HEADWAY_USB_CAN");
    if (serial == nullptr) GTEST_SKIP() << "HEADWAY_USB_CAN names no adapter";
    serial_ = serial;
    open();
  }
  void TearDown() override { close(); }

  void open() {
    stop_ = false;
    bus = std::make_unique<GsUsbBus>(config(), clock);
    server_ = std::thread([this] {
      while (!stop_.load()) bus->serve(milliseconds(20));
    });
  }
  void close() {
    stop_ = true;
    if (server_.joinable()) server_.join();
    bus.reset();
  }

  /// The peer is emulated too, and may be as slow as it likes. Unplugged over and over, it is soon looked
  /// for.
  GsUsbConfig config() const {
    return {.serial = serial_,
            .echo_timeout = std::chrono::seconds(2),
            .retry = {.first = milliseconds(20), .longest = milliseconds(50)}};
  }

  /// False where no adapter listens to commands.
  static bool tell(const std::string& command) {
    const char* pipe = std::getenv("HEADWAY_USB_CAN_COMMANDS");
    if (pipe == nullptr) return false;
    std::ofstream(pipe) << command << std::endl;
    return true;
  }

  template <class Condition>
  bool comes_true(Condition condition) {
    for (const Time limit = clock.now() + kPatience; !condition();) {
      if (clock.now() > limit) return false;
      clock.sleep_until(clock.now() + milliseconds(1));
    }
    return true;
  }

  /// Sends until frames are answered again; a frame that waits for an answer is not sent twice within 10 ms.
  bool answers() {
    std::array<hal::CanFrame, 64> some;
    while (bus->receive(some) > 0) {
    }
    return comes_true([&] {
      bus->send({.id = 0x400, .dlc = 1, .data = {7}, .stamp = {}});
      clock.sleep_until(clock.now() + milliseconds(10));
      return bus->receive(some) > 0 && some[0].id == 0x401;
    });
  }

  hal::MonotonicClock clock;
  std::unique_ptr<GsUsbBus> bus;

 private:
  std::string serial_;
  std::thread server_;
  std::atomic<bool> stop_{false};
};

hal::CanFrame numbered(std::uint32_t number) {
  hal::CanFrame frame{.id = number % 0x7FF, .dlc = 8, .data = {}, .stamp = {}};
  for (unsigned i = 0; i < 4; ++i) frame.data[i] = static_cast<std::uint8_t>(number >> (8 * i));
  return frame;
}

TEST_F(UsbCan, LosesAndReordersNoneOfAHundredThousandFrames) {
  const char* asked = std::getenv("HEADWAY_USB_CAN_FRAMES");  // fewer, where time is short
  const std::uint32_t frames = asked ? static_cast<std::uint32_t>(std::stoul(asked)) : 100'000;
  std::array<hal::CanFrame, 64> some;
  std::uint32_t sent = 0, came = 0;
  Time last_stamp{}, last_progress = clock.now();
  while (came < frames) {
    while (sent < frames && bus->send(numbered(sent))) ++sent;
    const std::size_t n = bus->receive(some);
    const Time now = clock.now();
    for (std::size_t i = 0; i < n; ++i, ++came) {
      const hal::CanFrame expected = numbered(came);
      ASSERT_EQ(some[i].id, expected.id + 1) << "frame " << came;
      ASSERT_EQ(some[i].data, expected.data) << "frame " << came;
      ASSERT_GE(some[i].stamp, last_stamp);
      ASSERT_LE(some[i].stamp, now);
      last_stamp = some[i].stamp;
    }
    if (n > 0) last_progress = now;
    ASSERT_LT(now - last_progress, kPatience) << came << " frames came, of " << sent << " sent";
    if (n == 0) clock.sleep_until(now + std::chrono::microseconds(200));
  }
  EXPECT_TRUE(comes_true([&] { return bus->stats().sent == frames; }));
  const hal::CanBusStats stats = bus->stats();
  EXPECT_EQ(stats.received, frames);
  EXPECT_EQ(stats.lost, 0u);
  EXPECT_EQ(stats.unusable, 0u);
  EXPECT_EQ(stats.gone, 0u);
  EXPECT_EQ(stats.state, CanBusState::kErrorActive);
}

TEST_F(UsbCan, SeesTheAdapterUnpluggedAndPluggedInAgain) {
  ASSERT_TRUE(answers());
  for (std::uint64_t round = 1; round <= 3; ++round) {
    if (!tell("unplug")) GTEST_SKIP() << "HEADWAY_USB_CAN_COMMANDS names no pipe";
    ASSERT_TRUE(comes_true([&] { return bus->state() == CanBusState::kGone; }));
    EXPECT_EQ(bus->stats().gone, round);
    EXPECT_FALSE(bus->send(numbered(0)));
    tell("plug");
    ASSERT_TRUE(comes_true([&] { return bus->state() == CanBusState::kErrorActive; }));
    EXPECT_TRUE(answers());
  }
}

TEST_F(UsbCan, UnpluggedInTheMiddleOfManyFramesItComesBack) {
  std::array<hal::CanFrame, 64> some;
  for (int i = 0; i < 2000; ++i) {
    bus->send(numbered(static_cast<std::uint32_t>(i)));
    bus->receive(some);
    if (i == 1000 && !tell("unplug")) GTEST_SKIP() << "HEADWAY_USB_CAN_COMMANDS names no pipe";
    clock.sleep_until(clock.now() + std::chrono::microseconds(200));
  }
  ASSERT_TRUE(comes_true([&] { return bus->state() == CanBusState::kGone; }));
  tell("plug");
  ASSERT_TRUE(comes_true([&] { return bus->state() == CanBusState::kErrorActive; }));
  EXPECT_TRUE(answers());
}

TEST_F(UsbCan, HoldsNothingMoreAfterFiftyUnplugs) {
  ASSERT_TRUE(answers());
  close();
  const Held while_closed = held_now();
  open();
  ASSERT_TRUE(comes_true([&] { return bus->state() == CanBusState::kErrorActive; }));
  const Held while_open = held_now();
  for (int i = 0; i < 50; ++i) {
    if (!tell("unplug")) GTEST_SKIP() << "HEADWAY_USB_CAN_COMMANDS names no pipe";
    ASSERT_TRUE(comes_true([&] { return bus->state() == CanBusState::kGone; })) << i;
    tell("plug");
    ASSERT_TRUE(comes_true([&] { return bus->state() == CanBusState::kErrorActive; })) << i;
    ASSERT_EQ(held_now(), while_open) << i;
    if (i % 5 != 0) continue;
    close();
    ASSERT_EQ(held_now(), while_closed) << i;
    open();
  }
  EXPECT_TRUE(answers());
}

TEST_F(UsbCan, HearsHowTheControllerFares) {
  ASSERT_TRUE(answers());
  for (const auto& [name, state] : {std::pair("warning", CanBusState::kErrorWarning),
                                    {"passive", CanBusState::kErrorPassive},
                                    {"active", CanBusState::kErrorActive}}) {
    if (!tell(std::string("state ") + name)) GTEST_SKIP() << "HEADWAY_USB_CAN_COMMANDS names no pipe";
    EXPECT_TRUE(comes_true([&, expected = state] { return bus->state() == expected; })) << name;
  }
  tell("state bus-off");
  EXPECT_TRUE(comes_true([&] { return bus->stats().bus_off == 1; }));
  EXPECT_TRUE(answers()) << "it is started anew";
  EXPECT_EQ(bus->stats().gone, 0u);
}

TEST_F(UsbCan, RecoversFromStalledEndpoints) {
  ASSERT_TRUE(answers());
  for (const char* endpoint : {"stall 0x81", "stall 0x02"}) {
    if (!tell(endpoint)) GTEST_SKIP() << "HEADWAY_USB_CAN_COMMANDS names no pipe";
    EXPECT_TRUE(answers()) << endpoint;
  }
  EXPECT_EQ(bus->stats().gone, 0u);
}

TEST_F(UsbCan, CountsWhatIsNoFrameAndWhatOverflowed) {
  ASSERT_TRUE(answers());
  // A controller that is started anew, for an echo was lost, forgets what it was told: it is told again.
  const auto is_counted = [&](const char* fault, std::uint64_t hal::CanBusStats::*count) {
    const std::uint64_t before = bus->stats().*count;
    return comes_true([&] { return tell(fault) && answers() && bus->stats().*count > before; });
  };
  if (!tell("next overflow")) GTEST_SKIP() << "HEADWAY_USB_CAN_COMMANDS names no pipe";
  EXPECT_TRUE(is_counted("next overflow", &hal::CanBusStats::lost));
  for (const char* fault : {"next echo", "next channel", "next half", "next long"}) {
    EXPECT_TRUE(is_counted(fault, &hal::CanBusStats::unusable)) << fault;
  }
  EXPECT_EQ(bus->stats().gone, 0u);
}

TEST_F(UsbCan, ComesBackWhenOtherNodesAcknowledgeAgain) {
  ASSERT_TRUE(answers());
  if (!tell("deaf")) GTEST_SKIP() << "HEADWAY_USB_CAN_COMMANDS names no pipe";
  const std::uint64_t refused = bus->stats().refused;
  EXPECT_TRUE(comes_true([&] {
    while (bus->send(numbered(1))) {
    }
    return bus->stats().refused > refused + 3;
  }));
  tell("hearing");
  EXPECT_TRUE(answers());
  EXPECT_EQ(bus->stats().gone, 0u);
}

TEST_F(UsbCan, IsUsedByOneProgramOnly) {
  EXPECT_THROW(GsUsbBus(config(), clock), Error);
  EXPECT_TRUE(answers());
}

}  // namespace
}  // namespace headway::drivers
