#include "sim_hal/sim_bus.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"

namespace headway::sim {
namespace {

hal::CanFrame frame(std::uint32_t id, std::uint8_t first = 0, std::uint8_t dlc = 8) {
  hal::CanFrame f{.id = id, .dlc = dlc};
  f.data[0] = first;
  return f;
}

std::vector<hal::CanFrame> drained(hal::CanBus& end) {
  std::vector<hal::CanFrame> all;
  std::array<hal::CanFrame, 7> some;
  while (const std::size_t n = end.receive(some))
    all.insert(all.end(), some.begin(), some.begin() + static_cast<long>(n));
  return all;
}

TEST(FrameTime, IsThatOfTheWorstCaseInTheLiterature) {
  // Davis, Burns, Bril, Lukkien 2007: 55 + 10 s bits for s bytes with an 11-bit identifier.
  for (std::uint8_t bytes = 0; bytes <= 8; ++bytes) {
    EXPECT_EQ(frame_time(bytes, 500e3), seconds((55 + 10 * bytes) / 500e3)) << int{bytes};
  }
}

TEST(SimBus, BringsAFrameToEveryoneButItsSender) {
  SimBus bus;
  auto &a = bus.attach("a"), &b = bus.attach("b"), &c = bus.attach("c");
  ASSERT_TRUE(a.send(frame(0x123, 7)));
  bus.advance(at_seconds(0.001));
  EXPECT_TRUE(drained(a).empty());
  for (auto* end : {&b, &c}) {
    const auto got = drained(*end);
    ASSERT_EQ(got.size(), 1U);
    EXPECT_EQ(got[0].id, 0x123U);
    EXPECT_EQ(got[0].data[0], 7);
    EXPECT_EQ(got[0].stamp, Time(frame_time(8, 500e3)));
  }
}

TEST(SimBus, DeliversNothingBeforeTheLastBit) {
  SimBus bus;
  auto &a = bus.attach("a"), &b = bus.attach("b");
  a.send(frame(0x123));
  bus.advance(Time(frame_time(8, 500e3) - Duration(1)));
  EXPECT_TRUE(drained(b).empty());
  bus.advance(Time(frame_time(8, 500e3)));
  EXPECT_EQ(drained(b).size(), 1U);
}

TEST(SimBus, LetsTheLowestIdentifierGoFirst) {
  SimBus bus;
  auto &a = bus.attach("a"), &b = bus.attach("b"), &c = bus.attach("c"), &listener = bus.attach("listener");
  a.send(frame(0x300));
  b.send(frame(0x100));
  c.send(frame(0x200));
  bus.advance(at_seconds(0.01));
  const auto got = drained(listener);
  ASSERT_EQ(got.size(), 3U);
  EXPECT_EQ(got[0].id, 0x100U);
  EXPECT_EQ(got[1].id, 0x200U);
  EXPECT_EQ(got[2].id, 0x300U);
}

TEST(SimBus, DoesNotInterruptAFrameOnTheWire) {
  SimBus bus;
  auto &a = bus.attach("a"), &b = bus.attach("b"), &listener = bus.attach("listener");
  a.send(frame(0x300));
  bus.advance(at_seconds(0.0001));
  b.send(frame(0x100));
  bus.advance(at_seconds(0.01));
  EXPECT_EQ(drained(listener).at(0).id, 0x300U);
}

/// Answers each frame at once with one of its own.
class Echo final : public hal::BusNode {
 public:
  explicit Echo(hal::CanBus& bus) : bus_(bus) {}
  void receive(const hal::CanFrame& f) noexcept override { bus_.send(frame(f.id + 1, f.data[0])); }
  void tick(Time) noexcept override {}

 private:
  hal::CanBus& bus_;
};

TEST(SimBus, LetsAListenerAnswerFromTheMomentOfReception) {
  SimBus bus;
  auto &a = bus.attach("a"), &b = bus.attach("b");
  Echo echo(b);
  b.listen(echo);
  a.send(frame(0x200));
  bus.advance(at_seconds(0.005));
  const auto got = drained(a);
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].stamp, Time(2 * frame_time(8, 500e3)));
}

TEST(SimBus, CountsWhatFindsNoRoom) {
  SimBus bus({.send_queue = 3, .receive_queue = 2});
  auto &a = bus.attach("a"), &b = bus.attach("b");
  for (int i = 0; i < 5; ++i) EXPECT_EQ(a.send(frame(0x100)), i < 3);
  bus.advance(at_seconds(1));
  EXPECT_EQ(drained(b).size(), 2U);
  EXPECT_EQ(bus.counters().send_refused, 2U);
  EXPECT_EQ(bus.counters().receive_lost, 1U);
  EXPECT_EQ(bus.counters().sent, 3U);
}

TEST(SimBus, DropsDelaysAndCorruptsOnDemand) {
  SimBus bus;
  auto &a = bus.attach("a"), &b = bus.attach("b");
  bus.drop_if([](const hal::CanFrame& f) { return f.id == 0x101; });
  bus.delay_by([](const hal::CanFrame& f) { return f.id == 0x102 ? seconds(0.05) : Duration{}; });
  bus.corrupt_by([](const hal::CanFrame& f) { return f.id == 0x103 ? std::optional(63U) : std::nullopt; });
  for (std::uint32_t id = 0x100; id <= 0x103; ++id) a.send(frame(id));
  bus.advance(at_seconds(0.01));
  auto got = drained(b);
  ASSERT_EQ(got.size(), 2U);
  EXPECT_EQ(got[0].id, 0x100U);
  EXPECT_EQ(got[0].data, frame(0).data);
  EXPECT_EQ(got[1].id, 0x103U);
  hal::CanFrame turned = frame(0x103);
  turned.data[7] = 0x80;
  EXPECT_EQ(got[1].data, turned.data);
  bus.advance(at_seconds(0.1));
  got = drained(b);
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].stamp, Time(3 * frame_time(8, 500e3) + seconds(0.05)));
  EXPECT_EQ(bus.counters().fault_dropped, 1U);
  EXPECT_EQ(bus.counters().fault_delayed, 1U);
  EXPECT_EQ(bus.counters().fault_corrupted, 1U);
}

TEST(SimBus, SilencesAnEndpointThatIsOffTheBus) {
  SimBus bus;
  auto &a = bus.attach("a"), &b = bus.attach("b");
  a.send(frame(0x100));
  a.set_state(hal::CanBusState::kBusOff);
  EXPECT_EQ(a.state(), hal::CanBusState::kBusOff);
  EXPECT_FALSE(a.send(frame(0x100)));
  b.send(frame(0x101));
  bus.advance(at_seconds(0.1));
  EXPECT_TRUE(drained(a).empty());
  EXPECT_TRUE(drained(b).empty());
  a.set_state(hal::CanBusState::kErrorActive);
  EXPECT_TRUE(a.send(frame(0x100)));
  bus.advance(at_seconds(0.2));
  EXPECT_EQ(drained(b).size(), 1U);
}

RC_GTEST_PROP(SimBus, KeepsEachSendersOrderAndNeverTheWireTwice, ()) {
  SimBus bus;
  std::vector<SimBus::Endpoint*> ends;
  for (const char* name : {"a", "b", "c"}) ends.push_back(&bus.attach(name));
  auto& listener = bus.attach("listener");
  const int count = *rc::gen::inRange(1, 60);
  std::map<int, int> sent;
  Time now{};
  for (int i = 0; i < count; ++i) {
    const int who = *rc::gen::inRange(0, 3);
    hal::CanFrame f =
        frame(static_cast<std::uint32_t>(*rc::gen::inRange(1, 0x7ff)), static_cast<std::uint8_t>(who),
              static_cast<std::uint8_t>(*rc::gen::inRange(2, 9)));
    f.data[1] = static_cast<std::uint8_t>(sent[who]++);
    RC_ASSERT(ends[static_cast<std::size_t>(who)]->send(f));
    now += std::chrono::microseconds(*rc::gen::inRange(0, 400));
    bus.advance(now);
  }
  bus.advance(now + seconds(1));
  const auto got = drained(listener);
  RC_ASSERT(got.size() == static_cast<std::size_t>(count));
  std::map<int, int> seen;
  Time before{};
  for (const auto& f : got) {
    RC_ASSERT(f.data[1] == seen[f.data[0]]++);
    RC_ASSERT(f.stamp >= before + frame_time(f.dlc, 500e3));
    before = f.stamp;
  }
}

TEST(SimBus, RefusesABitRateThatIsNotClassicCan) {
  EXPECT_THROW(SimBus({.bit_rate = 5e6}), InputError);
  EXPECT_THROW(SimBus({.send_queue = 0}), InputError);
}

}  // namespace
}  // namespace headway::sim
