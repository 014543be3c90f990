// Two head drives that are not ours: canopen_peer/peer.js in a process of its own, at the other end of a
// socket. It has no clock but the test's.
#pragma once

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "hal/can_bus.h"
#include "tests/source_dir/source_dir.h"

namespace headway::drivers::testing {

class CanopenPeer {
 public:
  CanopenPeer() {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw std::runtime_error("no socket can be had for the peer");
    socket_ = ends[0];
    const std::string script = source_dir() / "tests/drivers/canopen_peer/peer.js";
    const std::array<const char*, 3> arguments{"node", script.c_str(), nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    if (posix_spawnp(&process_, arguments[0], &actions, nullptr, const_cast<char* const*>(arguments.data()),
                     environ) != 0)
      process_ = -1;
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    is_there_ = process_ > 0 && !ask("get 17 1017 0").empty();
    if (!is_there_ && process_ > 0 && exit_code() != kNotInstalled)
      throw std::runtime_error(
          "the CANopen peer does not start; node tests/drivers/canopen_peer/peer.js says why");
  }
  ~CanopenPeer() {
    ::close(socket_);
    exit_code();
  }
  CanopenPeer(const CanopenPeer&) = delete;
  CanopenPeer& operator=(const CanopenPeer&) = delete;

  /// False where node or its package is not installed.
  bool is_there() const { return is_there_; }

  void send(const hal::CanFrame& frame) {
    std::string line = fmt::format("{:03X}#", frame.id);
    for (std::size_t i = 0; i < frame.dlc; ++i) line += fmt::format("{:02X}", frame.data[i]);
    tell(line);
  }
  /// Lets time pass there; what it sent meanwhile.
  std::vector<hal::CanFrame> step(Duration d, Time now) {
    tell(fmt::format("step {}", d / std::chrono::milliseconds(1)));
    std::vector<hal::CanFrame> frames;
    for (std::string line = hear(); line != "."; line = hear()) frames.push_back(frame_of(line, now));
    return frames;
  }
  void tell(const std::string& line) {
    const std::string text = line + "\n";
    if (::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size()))
      heard_.clear();  // it has ended: hear() says so
  }
  /// The answer; empty when the peer has ended, or says nothing for ten seconds.
  std::string ask(const std::string& line) {
    tell(line);
    return read_line();
  }

 private:
  static constexpr int kNotInstalled = 77;

  /// Of the process, which is ended if it has not ended itself.
  int exit_code() {
    int status = 0;
    if (process_ <= 0) return -1;
    kill(process_, SIGKILL);
    if (waitpid(std::exchange(process_, -1), &status, 0) < 0) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string hear() {
    std::string line = read_line();
    if (line.empty()) throw std::runtime_error("the CANopen peer has ended");
    return line;
  }
  std::string read_line() {
    for (std::size_t end = 0; (end = heard_.find('\n')) == std::string::npos;) {
      pollfd one{.fd = socket_, .events = POLLIN, .revents = 0};
      char some[4096];
      const ssize_t got = poll(&one, 1, 10'000) > 0 ? ::read(socket_, some, sizeof some) : 0;
      if (got <= 0) return {};
      heard_.append(some, static_cast<std::size_t>(got));
    }
    const std::string line = heard_.substr(0, heard_.find('\n'));
    heard_.erase(0, line.size() + 1);
    return line;
  }
  static hal::CanFrame frame_of(const std::string& line, Time now) {
    hal::CanFrame frame{.id = static_cast<std::uint32_t>(std::stoul(line, nullptr, 16)), .stamp = now};
    for (std::size_t at = line.find('#') + 1; at + 1 < line.size(); at += 2)
      frame.data[frame.dlc++] = static_cast<std::uint8_t>(std::stoul(line.substr(at, 2), nullptr, 16));
    return frame;
  }

  int socket_ = -1;
  pid_t process_ = -1;
  bool is_there_ = false;
  std::string heard_;
};

}  // namespace headway::drivers::testing
