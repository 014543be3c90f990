#include "app/service_manager.h"

#include <array>
#include <cstdlib>
#include <cstring>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

/// What systemd hears: sd_notify(3) sends datagrams to the socket that the environment names.
class Manager {
 public:
  Manager() : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    const std::string path = (folder_.path() / "notify").string();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error(path + ": cannot be bound");
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~Manager() {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    ::close(socket_);
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  void watch(const char* microseconds) { ::setenv("WATCHDOG_USEC", microseconds, 1); }
  /// The next message; empty when there is none.
  std::string heard() {
    std::array<char, 256> text;
    const ssize_t size = ::recv(socket_, text.data(), text.size(), 0);
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "";
  }

 private:
  TemporaryFolder folder_;
  int socket_;
};

TEST(ServiceManager, HearsHowTheProgramIs) {
  Manager manager;
  ServiceManager told;
  told.ready();
  told.status("walks");
  told.stopping();
  EXPECT_EQ(manager.heard(), "READY=1");
  EXPECT_EQ(manager.heard(), "STATUS=walks");
  EXPECT_EQ(manager.heard(), "STOPPING=1");
  EXPECT_EQ(manager.heard(), "");
}

TEST(ServiceManager, HearsThatItLivesAtHalfOfTheWatchdogsTime) {
  Manager manager;
  manager.watch("2000000");
  ServiceManager told;
  int heard = 0;
  for (int ms = 0; ms <= 10000; ms += 20) {
    told.alive(Time{} + std::chrono::milliseconds(ms));
    for (std::string text = manager.heard(); !text.empty(); text = manager.heard()) {
      EXPECT_EQ(text, "WATCHDOG=1");
      ++heard;
    }
  }
  EXPECT_EQ(heard, 11);
}

TEST(ServiceManager, IsNotToldOfLifeWhenItDoesNotWatch) {
  Manager manager;
  ServiceManager told;
  told.alive(Time{});
  EXPECT_EQ(manager.heard(), "");
}

TEST(ServiceManager, MayBeAbsent) {
  ::unsetenv("NOTIFY_SOCKET");
  ServiceManager told;
  told.ready();
  told.status("nobody hears this");
  told.alive(Time{});
  told.stopping();
}

}  // namespace
}  // namespace headway::app
