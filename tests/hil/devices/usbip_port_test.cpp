#include "tests/hil/usbip_port.h"

#include <algorithm>
#include <deque>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/hil/devices/usb_host.h"

namespace headway::hil {
namespace {

constexpr std::uint8_t kIn = 0x81, kOut = 0x02;
constexpr SetupPacket kAskDevice{
    .request_type = 0x80, .request = 6, .value = 0x0100, .index = 0, .length = 64};

// Keeps what it gets, and sends what a test puts into it.
class PlainDevice final : public UsbDevice {
 public:
  const UsbDescription& description() const override { return description_; }
  std::optional<Bytes> request(const SetupPacket&, ByteSpan sent) override {
    return Bytes(sent.begin(), sent.end());
  }
  void receive(std::uint8_t, ByteSpan bytes) override { received.emplace_back(bytes.begin(), bytes.end()); }
  std::optional<Bytes> send(std::uint8_t, std::size_t room) override {
    if (to_send.empty()) return std::nullopt;
    Bytes bytes = to_send.front();
    to_send.pop_front();
    bytes.resize(std::min(bytes.size(), room));
    return bytes;
  }
  void halt_cleared(std::uint8_t endpoint) override { cleared.push_back(endpoint); }
  void power_on() override { ++powered; }

  std::deque<Bytes> to_send;
  std::vector<Bytes> received;
  Bytes cleared;
  int powered = 0;

 private:
  UsbDescription description_{.speed = UsbSpeed::kHigh,
                              .device = {18, 1, 0, 2, 0, 0, 0, 64, 1, 2, 3, 4, 0, 0, 1, 2, 3, 1},
                              .configuration = {9, 2, 9, 0, 0, 1, 0, 0x80, 50},
                              .strings = {"A"}};
};

class UsbipPortTest : public ::testing::Test {
 protected:
  PlainDevice device_;
  UsbHost host_{device_};
};

SetupPacket clear_halt(std::uint8_t endpoint) {
  return {.request_type = 0x02, .request = 1, .value = 0, .index = endpoint, .length = 0};
}

TEST_F(UsbipPortTest, TellsItsDescriptorsUpToTheLengthAskedFor) {
  host_.control(kAskDevice);
  EXPECT_EQ(host_.answer()->data, device_.description().device);

  SetupPacket first_bytes = kAskDevice;
  first_bytes.length = 8;
  host_.control(first_bytes);
  EXPECT_EQ(host_.answer()->data, Bytes({18, 1, 0, 2, 0, 0, 0, 64}));

  host_.control({.request_type = 0x80, .request = 6, .value = 0x0301, .index = 0x0409, .length = 255});
  EXPECT_EQ(host_.answer()->data, Bytes({4, 3, 'A', 0}));
}

TEST_F(UsbipPortTest, StallsWhatItDoesNotKnow) {
  host_.control({.request_type = 0x80, .request = 6, .value = 0x0302, .index = 0, .length = 255});
  EXPECT_EQ(host_.answer()->status, -EPIPE);
}

RC_GTEST_PROP(UsbipPort, CarriesBulkDataUnchangedBothWays, ()) {
  PlainDevice device;
  UsbHost host(device);
  const auto packets = *rc::gen::container<std::vector<Bytes>>(rc::gen::arbitrary<Bytes>());
  for (const Bytes& packet : packets) {
    const auto sent = host.send_bulk(kOut, packet);
    const auto answer = host.answer();
    RC_ASSERT(answer && answer->sequence == sent && answer->length == packet.size());
    const auto asked = host.ask_bulk_in(kIn, 65536);
    RC_ASSERT(!host.answer());
    device.to_send.push_back(packet);
    const auto brought = host.answer();
    RC_ASSERT(brought && brought->sequence == asked && brought->data == packet);
  }
  RC_ASSERT(device.received == packets);
}

TEST_F(UsbipPortTest, AnswersWaitingTransfersInTheirOrder) {
  const auto first = host_.ask_bulk_in(kIn, 64), second = host_.ask_bulk_in(kIn, 64);
  EXPECT_FALSE(host_.answer());
  device_.to_send = {{1}, {2}};
  EXPECT_EQ(host_.answer()->sequence, first);
  EXPECT_EQ(host_.answer()->sequence, second);
}

TEST_F(UsbipPortTest, GivesBackATransferThatTheHostNoLongerWants) {
  const auto unwanted = host_.ask_bulk_in(kIn, 64);
  host_.unlink(unwanted);
  const auto answer = host_.answer();
  EXPECT_EQ(answer->command, UsbHost::kUnlinked);
  EXPECT_EQ(answer->status, -ECONNRESET);
  device_.to_send = {{1}};
  EXPECT_FALSE(host_.answer());

  host_.unlink(unwanted);
  EXPECT_EQ(host_.answer()->status, 0) << "it was done already";
}

TEST_F(UsbipPortTest, StallsAnEndpointUntilItsHaltIsCleared) {
  device_.to_send = {{1}};
  host_.port().stall(kIn);
  host_.ask_bulk_in(kIn, 64);
  EXPECT_EQ(host_.answer()->status, -EPIPE);
  host_.send_bulk(kOut, Bytes{1});
  EXPECT_EQ(host_.answer()->status, 0) << "the other endpoint goes on";

  host_.control(clear_halt(kIn));
  EXPECT_EQ(host_.answer()->status, 0);
  EXPECT_EQ(device_.cleared, Bytes{kIn});
  host_.ask_bulk_in(kIn, 64);
  EXPECT_EQ(host_.answer()->data, Bytes{1});
}

TEST_F(UsbipPortTest, StallsTransfersThatWaitAlready) {
  const auto waiting = host_.ask_bulk_in(kIn, 64);
  host_.port().stall(kIn);
  const auto answer = host_.answer();
  EXPECT_EQ(answer->sequence, waiting);
  EXPECT_EQ(answer->status, -EPIPE);
}

TEST_F(UsbipPortTest, StallsOneControlRequest) {
  host_.port().stall(0);
  host_.control(kAskDevice);
  EXPECT_EQ(host_.answer()->status, -EPIPE);
  host_.control(kAskDevice);
  EXPECT_EQ(host_.answer()->status, 0);
}

TEST_F(UsbipPortTest, HangsUpWhenUnpluggedAndComesBackWithoutAStall) {
  host_.port().stall(kIn);
  host_.ask_bulk_in(kIn, 64);
  host_.answer();
  host_.port().unplug();
  EXPECT_TRUE(host_.hung_up());
  EXPECT_EQ(host_.port().descriptor(), -1);

  host_.port().plug();
  EXPECT_EQ(device_.powered, 2);
  device_.to_send = {{1}};
  host_.ask_bulk_in(kIn, 64);
  EXPECT_EQ(host_.answer()->data, Bytes{1});
}

}  // namespace
}  // namespace headway::hil
