// A serial CAN adapter behind a pseudo-terminal: what it says, cut short, spoilt, refused and pulled out.
#include "drivers/slcan_bus.h"

#include <optional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/drivers/pty.h"
#include "tests/heap_count.h"
#include "tests/held.h"
#include "tests/temporary_folder.h"

namespace headway::drivers {
namespace {

using namespace std::chrono_literals;
using hal::CanBusState;
using ::testing::AllOf;
using testing::Deadline;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Pty;

constexpr std::string_view kGreeting = "\rC\rS6\rO\r";
constexpr hal::CanFrame kFrame{.id = 0x123, .dlc = 2, .data = {0xAB, 0xCD}};
constexpr std::string_view kFrameLine = "t1232ABCD\r";

/// An adapter under a name that stays, whatever tty it gets.
class SlcanBusTest : public ::testing::Test {
 protected:
  SlcanBusTest() {
    clock_.set(at_seconds(50));
    plug();
  }
  void plug() {
    pty_.emplace();
    std::filesystem::remove(path());
    std::filesystem::create_symlink(pty_->path(), path());
  }
  std::filesystem::path path() const { return folder_ / "adapter"; }
  SlcanBus& bus() {
    if (!bus_) {
      bus_.emplace(SlcanConfig{.path = path()}, clock_);
      EXPECT_EQ(pty_->read(kGreeting.size(), soon()), kGreeting);
    }
    return *bus_;
  }
  static Deadline soon() { return Deadline(10s); }

  /// What the bus hands over once it has read what the adapter says, and until there are so many frames.
  std::vector<hal::CanFrame> hear(std::string_view text, std::size_t frames) {
    bus();
    EXPECT_EQ(pty_->write(text), text.size());
    std::vector<hal::CanFrame> heard;
    const Deadline deadline = soon();
    do {
      std::array<hal::CanFrame, 3> some;
      EXPECT_TRUE(pty_->wait_near(deadline));
      const std::size_t count = bus().receive(some);
      heard.insert(heard.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(count));
    } while (heard.size() < frames && !deadline.passed());
    return heard;
  }
  /// Pulls it out, and waits until the bus has seen it.
  void unplug() {
    bus();
    pty_->unplug();
    const Deadline deadline = soon();
    std::array<hal::CanFrame, 3> some;
    while (bus().state() != CanBusState::kGone && !deadline.passed()) bus().receive(some);
    ASSERT_EQ(bus().state(), CanBusState::kGone);
  }

  TemporaryFolder folder_;
  hal::ManualClock clock_;
  std::optional<Pty> pty_;
  std::optional<SlcanBus> bus_;
};

TEST_F(SlcanBusTest, GoesOnTheBusAndOffAtTheEnd) {
  bus();
  bus_.reset();
  EXPECT_EQ(pty_->read(3, soon()), "\rC\r");
}

TEST_F(SlcanBusTest, SetsTheBitRateThatItIsTold) {
  const SlcanBus slow({.path = path(), .bit_rate = 125'000}, clock_);
  EXPECT_EQ(pty_->read(8, soon()), "\rC\rS4\rO\r");
}

TEST_F(SlcanBusTest, SendsLines) {
  EXPECT_TRUE(bus().send(kFrame));
  EXPECT_TRUE(bus().send({.id = 0x7FF}));
  EXPECT_EQ(pty_->read(16, soon()), std::string(kFrameLine) + "t7FF0\r");
  EXPECT_EQ(bus().stats().sent, 2u);
}

TEST_F(SlcanBusTest, StampsFramesWhenTheyAreRead) {
  bus();
  clock_.advance(3s);
  const auto frames = hear(kFrameLine, 1);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].stamp, clock_.now());
  EXPECT_EQ(frames[0].data, kFrame.data);
}

TEST_F(SlcanBusTest, CountsWhatItCannotUse) {
  const auto frames = hear("T000001001FF\rr1230\rR000001000\rhello\r\r\rz\rt1230\r", 1);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(bus().stats().unusable, 4u);
  EXPECT_EQ(bus().stats().received, 1u);
}

TEST_F(SlcanBusTest, IsInStepAgainAfterACutLine) {
  const auto frames = hear("t1238001122t4561AA\rt4562BBCC\rt12\rt1111\rt4560\r", 2);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].dlc, 2);
  EXPECT_EQ(frames[1].dlc, 0);
  EXPECT_EQ(bus().stats().unusable, 3u);
}

TEST_F(SlcanBusTest, TakesALineThatComesInPieces) {
  EXPECT_TRUE(hear("t12", 0).empty());
  EXPECT_TRUE(hear("32AB", 0).empty());
  EXPECT_EQ(hear("CD\rt", 1).size(), 1u);
  EXPECT_EQ(hear("1230\r", 1).size(), 1u);
  EXPECT_EQ(bus().stats().unusable, 0u);
}

TEST_F(SlcanBusTest, RefusesWhatNoClassicFrameCanHold) {
  EXPECT_FALSE(bus().send({.id = 0x800}));
  EXPECT_FALSE(bus().send({.id = 1, .dlc = 9}));
  EXPECT_EQ(bus().stats().refused, 2u);
}

TEST_F(SlcanBusTest, RefusesWithoutWaitingWhenTheLineIsFullAndCutsNoFrame) {
  std::size_t taken = 0;
  while (taken < 1'000'000 && bus().send(kFrame)) ++taken;
  ASSERT_GT(taken, 10u);
  ASSERT_LT(taken, 1'000'000u) << "the line never filled";
  EXPECT_FALSE(bus().send(kFrame));
  EXPECT_EQ(bus().stats().refused, 2u);
  EXPECT_EQ(bus().state(), CanBusState::kErrorActive);

  std::string all = pty_->read(taken * kFrameLine.size() - kFrameLine.size(), soon());
  const Deadline deadline = soon();
  std::size_t more = 0;
  while (more < 3 && !deadline.passed()) {
    more += bus().send(kFrame) ? 1 : 0;
    all += pty_->read();
  }
  all += pty_->read((taken + more) * kFrameLine.size() - all.size(), soon());
  ASSERT_EQ(all.size(), (taken + more) * kFrameLine.size());
  for (std::size_t at = 0; at < all.size(); at += kFrameLine.size())
    ASSERT_EQ(all.substr(at, kFrameLine.size()), kFrameLine) << "at " << at;
}

TEST_F(SlcanBusTest, GivesUpAnAdapterThatRefusesEverything) {
  hear(std::string(8, '\a') + "t1230\r" + std::string(15, '\a') + "t1230\r", 2);
  EXPECT_EQ(bus().state(), CanBusState::kErrorActive) << "an adapter that is full now and then";
  EXPECT_EQ(bus().stats().refused, 23u);
  ASSERT_EQ(pty_->write(std::string(16, '\a')), 16u);
  const Deadline deadline = soon();
  std::array<hal::CanFrame, 3> some;
  while (bus().state() != CanBusState::kGone && pty_->wait_near(deadline)) bus().receive(some);
  EXPECT_EQ(bus().state(), CanBusState::kGone);
  bus().serve(1s);
  EXPECT_EQ(bus().state(), CanBusState::kErrorActive);
  EXPECT_THAT(pty_->read(kGreeting.size(), soon()), HasSubstr(kGreeting));
}

TEST_F(SlcanBusTest, IsGoneWhenItIsPulledOutAndComesBackAsAnotherTty) {
  bus();
  ASSERT_EQ(hear("t123", 0).size(), 0u);
  unplug();
  EXPECT_FALSE(bus().send(kFrame));
  EXPECT_EQ(bus().stats().gone, 1u);
  std::filesystem::remove(path());
  bus().serve(10s);
  EXPECT_EQ(bus().state(), CanBusState::kGone);
  plug();
  bus().serve(10s);
  ASSERT_EQ(bus().state(), CanBusState::kErrorActive);
  EXPECT_EQ(pty_->read(kGreeting.size(), soon()), kGreeting);
  EXPECT_EQ(hear(kFrameLine, 1).size(), 1u);
  EXPECT_EQ(bus().stats().unusable, 0u) << "the line that was cut is forgotten";
  EXPECT_TRUE(bus().send(kFrame));
  EXPECT_EQ(bus().stats().gone, 1u);
}

TEST_F(SlcanBusTest, SeesByWritingTooThatItIsPulledOut) {
  for (int i = 0; i < 1'000'000 && bus().send(kFrame);) ++i;  // so that a part of a line waits
  pty_->unplug();
  const Deadline deadline = soon();
  while (bus().state() != CanBusState::kGone && !deadline.passed()) EXPECT_FALSE(bus().send(kFrame));
  ASSERT_EQ(bus().state(), CanBusState::kGone);
  EXPECT_EQ(bus().stats().gone, 1u);
  plug();
  bus().serve(1s);
  ASSERT_TRUE(bus().send(kFrame));
  const std::string expected = std::string(kGreeting) + std::string(kFrameLine);
  EXPECT_EQ(pty_->read(expected.size(), soon()), expected) << "the rest of an old line is stale";
}

TEST_F(SlcanBusTest, TriesAgainAfterHalfASecondAndThenEverLessOften) {
  bus();
  unplug();
  std::filesystem::remove(path());
  const Time lost = clock_.now();
  std::vector<Duration> tried;
  while (clock_.now() < lost + 20s) {
    bus().serve(60s);
    tried.push_back(clock_.now() - lost);
  }
  EXPECT_THAT(tried, ElementsAre(500ms, 1500ms, 3500ms, 7500ms, 12500ms, 17500ms, 22500ms));
  bus().serve(10ms);
  EXPECT_EQ(clock_.now() - lost, 22510ms) << "it takes no longer than it may";
}

TEST_F(SlcanBusTest, LeaksNothingInTenThousandUnplugs) {
  bus();
  const Held before = held_now();
  for (int i = 0; i < 10'000; ++i) {
    unplug();
    bus().serve(1s);
    ASSERT_EQ(bus().state(), CanBusState::kGone) << "its name leads nowhere";
    plug();
    bus().serve(5s);
    ASSERT_EQ(bus().state(), CanBusState::kErrorActive);
    if (i % 2 == 0) bus_.emplace(SlcanConfig{.path = path()}, clock_);
    ASSERT_EQ(held_now(), before) << i;
  }
}

TEST_F(SlcanBusTest, UsesNoHeapInTheBusLoop) {
  bus();
  std::string line;
  for (int i = 0; i < 40; ++i) line += "t1232ABCD\rT000001000\r\r\agarbage\r";
  std::array<hal::CanFrame, 8> frames;
  std::uint64_t used = 0, received = 0;
  for (int i = 0; i < 50; ++i) {
    pty_->write(line);
    pty_->wait_near(soon());
    const std::uint64_t before = heap_allocations();
    received += bus().receive(frames);
    bus().send(kFrame);
    bus().stats();
    used += heap_allocations() - before;
    pty_->read();
  }
  unplug();
  const std::uint64_t before = heap_allocations();
  bus().send(kFrame);
  bus().receive(frames);
  used += heap_allocations() - before;
  EXPECT_EQ(used, 0u);
  EXPECT_GT(received, 100u);
}

TEST_F(SlcanBusTest, IsServedFromAnotherThread) {
  bus();
  std::jthread server([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) bus().serve(5s);
  });
  std::array<hal::CanFrame, 8> frames;
  for (int i = 0; i < 20; ++i) {
    unplug();
    plug();
    const Deadline deadline = soon();
    while (bus().state() == CanBusState::kGone && !deadline.passed()) {
      bus().receive(frames);
      std::this_thread::yield();  // where one thread runs at a time, as under valgrind, the server is next
    }
    ASSERT_EQ(bus().state(), CanBusState::kErrorActive);
    EXPECT_TRUE(bus().send(kFrame));
    EXPECT_EQ(hear(kFrameLine, 1).size(), 1u);
  }
  EXPECT_EQ(bus().stats().gone, 20u);
}

TEST_F(SlcanBusTest, HasTheLineForItselfAlone) {
  bus();
  try {
    SlcanBus second(SlcanConfig{.path = path()}, clock_);
    FAIL() << "two on one line";
  } catch (const InputError& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("another program uses it"));
  }
  bus_.reset();
  EXPECT_NO_THROW(SlcanBus(SlcanConfig{.path = path()}, clock_)) << "free again";
}

TEST_F(SlcanBusTest, SaysWhatIsWrongAtTheStart) {
  const auto fault_of = [&](SlcanConfig config) -> std::string {
    try {
      SlcanBus bus(config, clock_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "no fault";
  };
  EXPECT_THAT(fault_of({}), HasSubstr("no tty is named"));
  EXPECT_THAT(fault_of({.path = folder_ / "absent"}),
              AllOf(HasSubstr("absent"), HasSubstr("No such file"), HasSubstr("by-id")));
  write_text(folder_ / "file", "no tty");
  EXPECT_THAT(fault_of({.path = folder_ / "file"}),
              AllOf(HasSubstr("file"), HasSubstr("expected the tty of")));
  EXPECT_THAT(fault_of({.path = path(), .bit_rate = 300'000}),
              AllOf(HasSubstr("300000"), HasSubstr("500000")));
  EXPECT_THAT(fault_of({.path = path(), .baud_rate = 300}), AllOf(HasSubstr("300"), HasSubstr("115200")));
}

}  // namespace
}  // namespace headway::drivers
