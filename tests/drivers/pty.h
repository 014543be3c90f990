// A serial line without one: a pseudo-terminal whose far end the test holds. No test waits longer than its
// deadline for what the other side does.
#pragma once

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

namespace headway::drivers::testing {

/// What is left until a moment; a test that comes to it fails.
class Deadline {
 public:
  explicit Deadline(std::chrono::milliseconds from_now) : at_(std::chrono::steady_clock::now() + from_now) {}
  bool passed() const { return left() <= 0; }
  int left() const {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(at_ - std::chrono::steady_clock::now());
    return static_cast<int>(left.count());
  }

 private:
  std::chrono::steady_clock::time_point at_;
};

class Pty {
 public:
  Pty() : master_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    if (master_ < 0 || grantpt(master_) < 0 || unlockpt(master_) < 0)
      throw std::runtime_error("no pseudo-terminal can be had");
    path_ = ptsname(master_);
    near_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    termios line{};
    tcgetattr(near_, &line);
    cfmakeraw(&line);
    tcsetattr(near_, TCSANOW, &line);
  }
  ~Pty() {
    unplug();
    ::close(near_);
  }
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;

  /// Of the near end, for a driver.
  const std::string& path() const { return path_; }
  int far_end() const { return master_; }

  /// The far end vanishes, as an adapter does that is pulled out.
  void unplug() {
    if (master_ >= 0) ::close(std::exchange(master_, -1));
  }
  /// How much of it the line took.
  std::size_t write(std::string_view text) {
    const ssize_t taken = ::write(master_, text.data(), text.size());
    return taken > 0 ? static_cast<std::size_t>(taken) : 0;
  }
  /// What has come to the far end by now.
  std::string read() {
    std::string all;
    char some[4096];
    for (ssize_t got = 0; (got = ::read(master_, some, sizeof some)) > 0;)
      all.append(some, static_cast<std::size_t>(got));
    return all;
  }
  /// Until the far end has so many bytes, or the deadline.
  std::string read(std::size_t bytes, const Deadline& deadline) {
    std::string all = read();
    while (all.size() < bytes && wait(master_, deadline)) all += read();
    return all;
  }
  /// Until something can be read at the near end, or it is hung up; false at the deadline.
  bool wait_near(const Deadline& deadline) const { return wait(near_, deadline); }
  /// Until the near end has taken all that was written; false at the deadline.
  bool wait_until_taken(const Deadline& deadline) const {
    pollfd one{.fd = near_, .events = POLLIN, .revents = 0};
    while (poll(&one, 1, 0) > 0)
      if (deadline.passed()) return false;
    return true;
  }

 private:
  static bool wait(int fd, const Deadline& deadline) {
    pollfd one{.fd = fd, .events = POLLIN, .revents = 0};
    return !deadline.passed() && poll(&one, 1, deadline.left()) > 0;
  }

  int master_, near_ = -1;
  std::string path_;
};

}  // namespace headway::drivers::testing
