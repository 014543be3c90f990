#include "tests/hil/emulated_gs_usb.h"

#include <chrono>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::hil {
namespace {

using namespace std::chrono_literals;
using Fault = EmulatedGsUsb::Fault;
using BusState = EmulatedGsUsb::BusState;

constexpr std::uint32_t kNoEcho = 0xffffffff;
constexpr std::uint32_t kStamps = 1U << 4;

// As the protocol's host frame without a stamp.
Bytes frame(std::uint32_t echo, std::uint32_t id, const Bytes& data) {
  Bytes bytes;
  append_le(bytes, echo, 4);
  append_le(bytes, id, 4);
  append_le(bytes, static_cast<std::uint32_t>(data.size()), 4);
  bytes.insert(bytes.end(), data.begin(), data.end());
  bytes.resize(20);
  return bytes;
}

class Bench {
 public:
  explicit Bench(std::uint32_t flags = 0) { start(flags); }

  void start(std::uint32_t flags) {
    Bytes mode;
    append_le(mode, 1, 4);
    append_le(mode, flags, 4);
    adapter.request({.request_type = 0x41, .request = 2, .value = 0, .index = 0, .length = 8}, mode);
  }
  void send(const Bytes& bytes) { adapter.receive(EmulatedGsUsb::kOut, bytes); }
  std::optional<Bytes> read() { return adapter.send(EmulatedGsUsb::kIn, 64); }

  hal::ManualClock clock;
  EmulatedGsUsb adapter{"A1", clock};
};

RC_GTEST_PROP(EmulatedGsUsb, EchoesEveryFrameAndAnswersItUnderTheNextIdentifier, ()) {
  Bench bench;
  const auto count = *rc::gen::inRange(0, 40);
  for (int i = 0; i < count; ++i) {
    const auto echo = *rc::gen::inRange<std::uint32_t>(0, 10);
    const auto id = *rc::gen::inRange<std::uint32_t>(0, 0x7FF);
    const auto data = *rc::gen::resize(8, rc::gen::arbitrary<Bytes>());
    RC_PRE(data.size() <= 8);
    bench.send(frame(echo, id, data));
    RC_ASSERT(bench.read() == frame(echo, id, data));
    RC_ASSERT(bench.read() == frame(kNoEcho, id + 1, data));
    RC_ASSERT(!bench.read());
  }
  RC_ASSERT(bench.adapter.counts().sent == static_cast<std::uint64_t>(count));
  RC_ASSERT(bench.adapter.counts().misused == 0u);
}

TEST(EmulatedGsUsb, CountsWhatARealOneCannotUse) {
  Bench bench;
  bench.send(Bytes(19));
  bench.send(frame(0, 1, Bytes(9)));
  EXPECT_EQ(bench.adapter.counts().misused, 2u);
  bench.adapter.hold(true);
  for (std::uint32_t i = 0; i < 11; ++i) bench.send(frame(i, 1, {}));
  EXPECT_EQ(bench.adapter.counts().misused, 3u) << "it has ten slots";
  bench.adapter.power_on();
  bench.send(frame(0, 1, {}));
  EXPECT_EQ(bench.adapter.counts().misused, 4u) << "it was not started";
}

TEST(EmulatedGsUsb, StampsFramesInMicrosecondsThatWrap) {
  Bench bench(kStamps);
  bench.clock.set(Time((1LL << 32) * 1us + 5us));
  bench.adapter.bus_frame(1, {});
  const auto bytes = bench.read();
  ASSERT_TRUE(bytes);
  ASSERT_EQ(bytes->size(), 24u);
  EXPECT_EQ(read_le(*bytes, 20, 4), 5u);
}

TEST(EmulatedGsUsb, SpoilsOnePacketAsItIsTold) {
  Bench bench;
  const auto spoilt = [&](Fault fault) {
    bench.adapter.inject(fault);
    bench.adapter.bus_frame(0x123, Bytes{1});
    return bench.read().value_or(Bytes{});
  };
  EXPECT_NE(read_le(spoilt(Fault::kUnknownEcho), 0, 4), kNoEcho);
  EXPECT_EQ(spoilt(Fault::kWrongDlc)[8], 9);
  EXPECT_EQ(spoilt(Fault::kWrongChannel)[9], 3);
  EXPECT_EQ(spoilt(Fault::kOverflow)[10], 1);
  EXPECT_EQ(spoilt(Fault::kHalf).size(), 10u);
  EXPECT_EQ(spoilt(Fault::kLong).size(), 64u);
  bench.adapter.bus_frame(0x123, Bytes{1});
  EXPECT_EQ(bench.read(), frame(kNoEcho, 0x123, {1})) << "one only";
}

TEST(EmulatedGsUsb, HoldsItsAnswersBackUntilTheyAreReleased) {
  Bench bench;
  bench.adapter.hold(true);
  bench.send(frame(0, 1, {}));
  EXPECT_FALSE(bench.read());
  bench.adapter.hold(false);
  EXPECT_EQ(bench.read(), frame(0, 1, {}));
}

TEST(EmulatedGsUsb, EchoesNothingThatNobodyAcknowledges) {
  Bench bench;
  bench.adapter.set_deaf(true);
  bench.send(frame(0, 1, {}));
  EXPECT_FALSE(bench.read());
}

TEST(EmulatedGsUsb, IsOffTheBusUntilItIsStartedAnew) {
  Bench bench;
  bench.adapter.set_bus_state(BusState::kBusOff);
  const auto error = bench.read();
  ASSERT_TRUE(error);
  EXPECT_EQ(read_le(*error, 4, 4), 0x20000040u) << "error frame, bus-off (linux/can/error.h)";
  bench.send(frame(0, 1, {}));
  EXPECT_FALSE(bench.read());
  bench.start(0);
  bench.send(frame(0, 1, {}));
  EXPECT_EQ(bench.read(), frame(0, 1, {}));
}

}  // namespace
}  // namespace headway::hil
