// The SocketCAN bus on a real kernel, against can-utils. HEADWAY_CAN names a virtual interface (vcan) that is
// up and that nobody else uses; the tests take it down and make it anew, so they need root.
#include <array>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "drivers/can_links.h"
#include "drivers/socketcan_bus.h"
#include "hal/clock.h"
#include "hal/error.h"
#include "tests/held.h"

namespace headway::drivers {
namespace {

using namespace std::chrono_literals;
using hal::CanBusState;

std::string interface() {
  const char* name = std::getenv("HEADWAY_CAN");
  return name ? name : "";
}

/// A program that runs beside the test, its output readable; ended at the latest with the test.
class Process {
 public:
  explicit Process(std::vector<std::string> arguments) {
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw Error("no pipe can be had");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    const int fault = posix_spawnp(&id_, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    output_ = ends[0];
    if (fault != 0) throw Error(arguments[0] + " cannot be started; install can-utils and iproute2");
  }
  ~Process() {
    close(output_);
    if (ended_) return;
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Its exit code, once it has ended by itself.
  int wait() {
    int status = 0;
    waitpid(id_, &status, 0);
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  /// Its next line of output; nothing when none comes for so long.
  std::optional<std::string> line(std::chrono::milliseconds patience) {
    for (;;) {
      if (const std::size_t end = text_.find('\n'); end != std::string::npos) {
        const std::string one = text_.substr(0, end);
        text_.erase(0, end + 1);
        return one;
      }
      pollfd pipe{.fd = output_, .events = POLLIN, .revents = 0};
      if (poll(&pipe, 1, static_cast<int>(patience.count())) <= 0) return std::nullopt;
      std::array<char, 4096> some;
      const ssize_t got = read(output_, some.data(), some.size());
      if (got <= 0) return std::nullopt;
      text_.append(some.data(), static_cast<std::size_t>(got));
    }
  }

 private:
  pid_t id_ = -1;
  int output_ = -1;
  bool ended_ = false;
  std::string text_;
};

int run(std::vector<std::string> arguments) { return Process(std::move(arguments)).wait(); }
/// As cansend writes it: 123#1122.
void cansend(const std::string& frame) { ASSERT_EQ(run({"cansend", interface(), frame}), 0) << frame; }
void ip_link(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"ip", "link"});
  ASSERT_EQ(run(arguments), 0) << arguments[2];
}

class CanOnAKernel : public ::testing::Test {
 protected:
  void SetUp() override {
    if (interface().empty()) GTEST_SKIP() << "HEADWAY_CAN names no interface, expected a vcan that is up";
  }
  /// All that comes until there are so many frames, or none has come for seconds.
  std::vector<hal::CanFrame> receive(SocketCanBus& bus, std::size_t most) {
    std::vector<hal::CanFrame> all(most);
    std::size_t count = 0;
    Time heard = clock_.now();
    while (count < most && clock_.now() < heard + 5s) {
      const std::size_t more = bus.receive(std::span(all).subspan(count));
      if (more > 0) heard = clock_.now();
      count += more;
    }
    all.resize(count);
    return all;
  }
  /// Only what is there.
  static std::vector<hal::CanFrame> drain(SocketCanBus& bus) {
    std::vector<hal::CanFrame> all(4096);
    all.resize(bus.receive(all));
    return all;
  }

  hal::MonotonicClock clock_;
};

TEST_F(CanOnAKernel, HearsWhatCansendSendsAndWhen) {
  SocketCanBus bus({.interface = interface()}, clock_);
  const Time before = clock_.now();
  cansend("123#11AAFF");
  const Time after = clock_.now();
  const auto frames = receive(bus, 1);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].id, 0x123u);
  EXPECT_EQ(frames[0].dlc, 3);
  EXPECT_EQ(frames[0].data, (std::array<std::uint8_t, 8>{0x11, 0xAA, 0xFF}));
  EXPECT_GE(frames[0].stamp, before);
  EXPECT_LE(frames[0].stamp, after) << "the kernel's stamp, not the time at which it was read";
}

TEST_F(CanOnAKernel, HearsThousandsOfFramesInOrder) {
  constexpr std::size_t kFrames = 2000;
  SocketCanBus bus({.interface = interface()}, clock_);
  Process peer({"cangen", interface(), "-g", "1", "-I", "i", "-L", "i", "-n", std::to_string(kFrames)});
  const auto frames = receive(bus, kFrames);
  ASSERT_EQ(frames.size(), kFrames) << bus.stats().lost << " were lost";
  for (std::size_t i = 1; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].id, (frames[i - 1].id + 1) % 0x800) << "frame " << i;
    ASSERT_EQ(frames[i].dlc, (frames[i - 1].dlc + 1) % 9) << "frame " << i;
    ASSERT_GE(frames[i].stamp, frames[i - 1].stamp) << "frame " << i;
  }
  EXPECT_EQ(peer.wait(), 0);
}

TEST_F(CanOnAKernel, CandumpHearsEveryFrameInOrder) {
  constexpr std::uint32_t kFrames = 3000;
  constexpr hal::CanFrame kReady{.id = 0x7FF};
  SocketCanBus bus({.interface = interface()}, clock_);
  Process candump({"candump", "-L", interface()});
  // It says nothing before it hears something.
  std::optional<std::string> first;
  for (int tries = 0; tries < 500 && !first; ++tries) {
    bus.send(kReady);
    first = candump.line(20ms);
  }
  ASSERT_TRUE(first);
  std::uint32_t sent = 0, heard = 0;
  while (heard < kFrames) {
    for (; sent < kFrames && sent < heard + 100; ++sent) {
      const hal::CanFrame frame{
          .id = sent % 0x7FF,
          .dlc = 2,
          .data = {static_cast<std::uint8_t>(sent >> 8), static_cast<std::uint8_t>(sent)}};
      ASSERT_TRUE(bus.send(frame));
    }
    const auto line = candump.line(5000ms);
    ASSERT_TRUE(line) << "frame " << heard << " never came";
    std::string stamp, where, what;
    std::istringstream(*line) >> stamp >> where >> what;
    if (what == "7FF#") continue;
    std::array<char, 16> expected;
    std::snprintf(expected.data(), expected.size(), "%03X#%04X", heard % 0x7FF, heard);
    ASSERT_EQ(what, expected.data());
    ++heard;
  }
}

TEST_F(CanOnAKernel, DoesNotHearItself) {
  SocketCanBus bus({.interface = interface()}, clock_);
  ASSERT_TRUE(bus.send({.id = 0x200}));
  cansend("201#");
  const auto frames = receive(bus, 1);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].id, 0x201u);
}

TEST_F(CanOnAKernel, FiltersByIdentifier) {
  SocketCanBus all({.interface = interface()}, clock_);
  SocketCanBus some({.interface = interface(), .identifiers = {0x130, 0x711}}, clock_);
  for (const char* frame : {"130#01", "131#02", "00000130#03", "130#R", "711#05"}) cansend(frame);
  const auto few = drain(some), many = drain(all);
  ASSERT_EQ(few.size(), 2u);
  EXPECT_EQ(few[0].id, 0x130u);
  EXPECT_EQ(few[1].id, 0x711u);
  EXPECT_EQ(some.stats().unusable, 0u);
  EXPECT_EQ(many.size(), 3u);
  EXPECT_EQ(all.stats().unusable, 2u);
}

TEST_F(CanOnAKernel, HearsTheControllersErrors) {
  SocketCanBus bus({.interface = interface(), .identifiers = {0x130}}, clock_);
  const auto state_after = [&](const std::string& error) {
    cansend(error);
    drain(bus);
    return bus.state();
  };
  EXPECT_EQ(state_after("20000204#0008000000006103"), CanBusState::kErrorWarning);
  EXPECT_EQ(bus.stats().transmit_errors, 0x61);
  EXPECT_EQ(bus.stats().receive_errors, 3);
  EXPECT_EQ(state_after("20000004#0010000000000000"), CanBusState::kErrorPassive);
  EXPECT_EQ(state_after("20000040#0000000000000000"), CanBusState::kBusOff);
  EXPECT_FALSE(bus.send({.id = 1}));
  EXPECT_EQ(state_after("20000100#0000000000000000"), CanBusState::kErrorActive);
  EXPECT_TRUE(bus.send({.id = 1}));
  EXPECT_EQ(bus.stats().bus_off, 1u);
}

TEST_F(CanOnAKernel, KnowsHowManyItLost) {
  constexpr std::size_t kFrames = 5000;
  SocketCanBus bus({.interface = interface()}, clock_);
  ASSERT_EQ(run({"cangen", interface(), "-g", "0", "-I", "i", "-n", std::to_string(kFrames)}), 0);
  std::size_t received = drain(bus).size();
  EXPECT_LT(received, kFrames) << "the socket held all of them, so nothing is shown";
  cansend("123#");  // the kernel tells with the next frame that it keeps
  received += drain(bus).size();
  EXPECT_EQ(received + bus.stats().lost, kFrames + 1);
}

TEST_F(CanOnAKernel, NeverWaitsForAFullQueue) {
  constexpr std::size_t kRoom = 5;
  hal::ManualClock clock;
  SocketCanBus bus({.interface = interface()}, clock);
  // A bus on which nothing gets away: the kernel holds frames back for minutes, and no more than a few.
  ASSERT_EQ(run({"tc", "qdisc", "add", "dev", interface(), "root", "netem", "delay", "200s", "limit",
                 std::to_string(kRoom)}),
            0);
  std::size_t sent = 0;
  while (sent < 100 && bus.send({.id = 1})) ++sent;
  EXPECT_EQ(sent, kRoom);
  EXPECT_EQ(bus.state(), CanBusState::kErrorActive);
  clock.advance(100ms);
  EXPECT_FALSE(bus.send({.id = 1}));
  EXPECT_EQ(bus.state(), CanBusState::kBusOff);
  ASSERT_EQ(run({"tc", "qdisc", "del", "dev", interface(), "root"}), 0);
  EXPECT_TRUE(bus.send({.id = 1}));
  EXPECT_EQ(bus.state(), CanBusState::kErrorActive);
  EXPECT_EQ(bus.stats().bus_off, 1u);
}

TEST_F(CanOnAKernel, ComesBackWhenTheInterfaceDoes) {
  hal::ManualClock clock;
  clock.set(clock_.now());
  SocketCanBus bus({.interface = interface()}, clock);
  ip_link({"set", interface(), "down"});
  drain(bus);
  EXPECT_EQ(bus.state(), CanBusState::kGone);
  clock.advance(500ms);
  drain(bus);
  EXPECT_EQ(bus.state(), CanBusState::kGone) << "it is still down";
  ip_link({"set", interface(), "up"});
  clock.advance(1s);
  drain(bus);
  ASSERT_EQ(bus.state(), CanBusState::kErrorActive);
  cansend("123#");
  EXPECT_EQ(drain(bus).size(), 1u);
}

TEST_F(CanOnAKernel, ComesBackUnderAnotherIndex) {
  hal::ManualClock clock;
  clock.set(clock_.now());
  SocketCanBus bus({.interface = interface(), .identifiers = {0x130}}, clock);
  for (int i = 0; i < 4; ++i) {
    const unsigned before = if_nametoindex(interface().c_str());
    ip_link({"del", interface()});
    if (i % 2 == 0)
      drain(bus);
    else
      EXPECT_FALSE(bus.send({.id = 1}));
    ASSERT_EQ(bus.state(), CanBusState::kGone);
    ip_link({"add", interface(), "type", "vcan"});
    ip_link({"set", interface(), "up"});
    EXPECT_NE(if_nametoindex(interface().c_str()), before);
    clock.advance(5s);
    drain(bus);
    ASSERT_EQ(bus.state(), CanBusState::kErrorActive);
    cansend("131#");
    cansend("130#");
    EXPECT_EQ(drain(bus).size(), 1u);
    EXPECT_TRUE(bus.send({.id = 1}));
  }
  EXPECT_EQ(bus.stats().gone, 4u);
}

TEST_F(CanOnAKernel, IsListed) {
  const auto ours = [] {
    for (const CanLink& link : list_can_links())
      if (link.name == interface()) return link;
    return CanLink{};
  };
  EXPECT_EQ(ours().kind, "vcan");
  EXPECT_TRUE(ours().is_up);
  EXPECT_EQ(ours().bitrate, 0u) << "a virtual bus has none";
  ip_link({"set", interface(), "down"});
  EXPECT_FALSE(ours().is_up);
  ip_link({"set", interface(), "up"});
}

TEST_F(CanOnAKernel, HoldsNothingMoreAfterFiftyUnplugs) {
  hal::ManualClock clock;
  clock.set(clock_.now());
  std::optional<SocketCanBus> bus(std::in_place, SocketCanConfig{.interface = interface()}, clock);
  const Held before = held_now();
  for (int i = 0; i < 50; ++i) {
    ip_link({"del", interface()});
    drain(*bus);
    ASSERT_EQ(bus->state(), CanBusState::kGone) << i;
    ip_link({"add", interface(), "up", "type", "vcan"});
    if (i % 2 == 0) {
      clock.advance(5s);
      drain(*bus);
    } else {
      bus.emplace(SocketCanConfig{.interface = interface()}, clock);
    }
    ASSERT_EQ(bus->state(), CanBusState::kErrorActive) << i;
    ASSERT_EQ(held_now(), before) << i;
  }
  EXPECT_TRUE(bus->send({.id = 1}));
}

TEST_F(CanOnAKernel, SaysWhatIsWrongWithAnInterface) {
  const auto fault_of = [&](const std::string& name) -> std::string {
    try {
      SocketCanBus bus({.interface = name}, clock_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "no fault";
  };
  EXPECT_NE(fault_of("nocan7").find("there is no such interface"), std::string::npos);
  ip_link({"set", "lo", "up"});
  EXPECT_NE(fault_of("lo").find("is no CAN interface"), std::string::npos);
  ip_link({"set", interface(), "down"});
  EXPECT_NE(fault_of(interface()).find("is down"), std::string::npos);
  ip_link({"set", interface(), "up"});
}

}  // namespace
}  // namespace headway::drivers
