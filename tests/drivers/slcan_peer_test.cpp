// The serial adapter's driver against python3-can, an independent maker of the same lines: two
// pseudo-terminals with the test as the cable between them.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include "drivers/slcan_bus.h"
#include "tests/drivers/pty.h"
#include "tests/source_dir/source_dir.h"

namespace headway::drivers {
namespace {

using namespace std::chrono_literals;
using testing::Deadline;
using testing::Pty;

constexpr int kNoPython = 77;

/// The script slcan_peer.py, ended at the latest with the test.
class Peer {
 public:
  Peer(const std::string& mode, const std::string& tty) {
    const std::string script = source_dir() / "tests/drivers/slcan_peer.py";
    // Debian's own interpreter: that is where python3-can is installed.
    const std::array<const char*, 5> arguments{"/usr/bin/python3", script.c_str(), mode.c_str(), tty.c_str(),
                                               nullptr};
    if (posix_spawn(&process_, arguments[0], nullptr, nullptr, const_cast<char* const*>(arguments.data()),
                    environ) != 0)
      code_ = kNoPython;
  }
  ~Peer() {
    if (ended()) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  bool ended() {
    int status = 0;
    if (!code_ && waitpid(process_, &status, WNOHANG) == process_)
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return code_.has_value();
  }
  int code() const { return code_.value_or(-1); }

 private:
  pid_t process_ = -1;
  std::optional<int> code_;
};

/// Carries bytes between the far ends of two lines.
class Cable {
 public:
  Cable(Pty& one, Pty& other) : one_(one), other_(other) {}
  /// Waits until there is something to carry, a few milliseconds at most, and carries it.
  void carry() {
    std::array<pollfd, 2> ends{pollfd{one_.far_end(), events(to_one_), 0},
                               pollfd{other_.far_end(), events(to_other_), 0}};
    poll(ends.data(), ends.size(), 5);
    to_other_ += one_.read();
    to_one_ += other_.read();
    to_one_.erase(0, one_.write(to_one_));
    to_other_.erase(0, other_.write(to_other_));
  }

 private:
  static short events(const std::string& waiting) {
    return static_cast<short>(waiting.empty() ? POLLIN : POLLIN | POLLOUT);
  }

  Pty& one_;
  Pty& other_;
  std::string to_one_, to_other_;
};

/// As slcan_peer.py makes them.
std::vector<hal::CanFrame> all_frames() {
  std::vector<hal::CanFrame> all;
  for (std::uint32_t id = 0; id < 0x800; ++id) {
    for (std::uint8_t dlc = 0; dlc <= 8; ++dlc) {
      hal::CanFrame frame{.id = id, .dlc = dlc};
      for (std::uint32_t i = 0; i < dlc; ++i)
        frame.data[i] = static_cast<std::uint8_t>(id * 7 + dlc * 13u + i * 29);
      all.push_back(frame);
    }
  }
  return all;
}

class SlcanPeer : public ::testing::Test {
 protected:
  hal::ManualClock clock_;
  Pty ours_, theirs_;
  Cable cable_{ours_, theirs_};
  SlcanBus bus_{{.path = ours_.path()}, clock_};
  const Deadline deadline_{120s};
};

TEST_F(SlcanPeer, HearsEveryIdentifierAndLengthInOrder) {
  Peer peer("send", theirs_.path());
  const std::vector<hal::CanFrame> expected = all_frames();
  // 8 identifiers x 9 lengths x (29 bits, remote), and the peer's own "O" and "C".
  constexpr std::uint64_t kUnusable = 8 * 9 * 2 + 2;
  std::size_t heard = 0;
  while ((heard < expected.size() || bus_.stats().unusable < kUnusable) && !deadline_.passed()) {
    cable_.carry();
    std::array<hal::CanFrame, 64> frames;
    const std::size_t count = bus_.receive(frames);
    for (std::size_t i = 0; i < count; ++i, ++heard) {
      ASSERT_LT(heard, expected.size());
      ASSERT_EQ(frames[i].id, expected[heard].id);
      ASSERT_EQ(frames[i].dlc, expected[heard].dlc);
      ASSERT_EQ(frames[i].data, expected[heard].data) << "id " << frames[i].id << ", frame " << heard;
    }
    if (heard == 0 && peer.ended() && peer.code() == kNoPython)
      GTEST_SKIP() << "python3-can is not installed";
  }
  EXPECT_EQ(heard, expected.size());
  EXPECT_EQ(bus_.stats().unusable, kUnusable);
}

TEST_F(SlcanPeer, IsHeardWithEveryIdentifierAndLengthInOrder) {
  Peer peer("hear", theirs_.path());
  const std::vector<hal::CanFrame> frames = all_frames();
  std::size_t sent = 0;
  // Only when its "O" has come the peer listens: before that its line was not raw yet.
  while (bus_.stats().unusable == 0 && !peer.ended() && !deadline_.passed()) {
    cable_.carry();
    std::array<hal::CanFrame, 1> none;
    bus_.receive(none);
  }
  while (!peer.ended() && !deadline_.passed()) {
    while (sent < frames.size() && bus_.send(frames[sent])) ++sent;
    cable_.carry();
  }
  if (peer.code() == kNoPython) GTEST_SKIP() << "python3-can is not installed";
  EXPECT_EQ(peer.code(), 0);
  EXPECT_EQ(bus_.stats().sent, frames.size());
  EXPECT_GT(bus_.stats().refused, 0u) << "the line was never full";
}

}  // namespace
}  // namespace headway::drivers
