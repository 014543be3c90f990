#include "app/local_socket.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "hal/error.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

std::string echo(std::string_view line) { return "you said " + std::string(line); }

/// A client that does as it likes.
class Client {
 public:
  explicit Client(const std::filesystem::path& path)
      : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// How many bytes went.
  std::size_t say(std::string_view text) const {
    const ssize_t sent = ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
    return sent < 0 ? 0 : static_cast<std::size_t>(sent);
  }
  std::string hear() const {
    std::string heard(1u << 20, '\0');
    const ssize_t got = ::recv(socket_, heard.data(), heard.size(), 0);
    heard.resize(got < 0 ? 0 : static_cast<std::size_t>(got));
    return heard;
  }
  bool hung_up() const {
    char byte;
    return ::recv(socket_, &byte, 1, 0) == 0;
  }

 private:
  int socket_;
};

struct Bench {
  TemporaryFolder folder;
  std::filesystem::path path = folder / "control.sock";
  LocalServer server{path};
};

TEST(LocalSocket, AnswersEachLineWithALine) {
  Bench bench;
  const Client client(bench.path);
  client.say("one\ntwo\nthr");
  bench.server.serve(echo);
  EXPECT_EQ(client.hear(), "you said one\nyou said two\n");
  client.say("ee\n");
  bench.server.serve(echo);
  EXPECT_EQ(client.hear(), "you said three\n");
}

TEST(LocalSocket, IsOfTheOwnerAndTheGroup) {
  const Bench bench;
  struct stat file {};
  ASSERT_EQ(::stat(bench.path.c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777u, 0660u);
}

TEST(LocalSocket, HangsUpOnALineWithoutEnd) {
  Bench bench;
  const Client client(bench.path);
  for (int i = 0; i < 3; ++i) {
    client.say(std::string(LocalServer::kLongestLine, 'x'));
    bench.server.serve(echo);
  }
  EXPECT_TRUE(client.hung_up());
  EXPECT_EQ(bench.server.clients(), 0u);
}

TEST(LocalSocket, NeverWaitsForWhoDoesNotReadAndHangsUpWhenTooMuchWaits) {
  Bench bench;
  const Client deaf(bench.path), other(bench.path);
  const auto much = [](std::string_view) { return std::string(5000, 'y'); };
  bench.server.serve(much);
  ASSERT_EQ(bench.server.clients(), 2u);
  for (int i = 0; i < 1000 && bench.server.clients() == 2; ++i) {
    deaf.say("?\n");
    bench.server.serve(much);
  }
  EXPECT_EQ(bench.server.clients(), 1u);
  other.say("still there\n");
  bench.server.serve(echo);
  EXPECT_EQ(other.hear(), "you said still there\n");
}

TEST(LocalSocket, MakesRoomForNewcomers) {
  Bench bench;
  std::vector<std::unique_ptr<Client>> clients;
  for (std::size_t i = 0; i <= LocalServer::kMostClients; ++i) {
    clients.push_back(std::make_unique<Client>(bench.path));
    bench.server.serve(echo);
  }
  EXPECT_EQ(bench.server.clients(), LocalServer::kMostClients);
  EXPECT_TRUE(clients.front()->hung_up());
  clients.back()->say("here\n");
  bench.server.serve(echo);
  EXPECT_EQ(clients.back()->hear(), "you said here\n");
}

TEST(LocalSocket, LeavesNothingBehind) {
  TemporaryFolder folder;
  { const LocalServer server(folder / "control.sock"); }
  EXPECT_FALSE(std::filesystem::exists(folder / "control.sock"));
}

TEST(LocalSocket, TakesOverWhatAProgramThatIsGoneLeftBehind) {
  TemporaryFolder folder;
  const auto path = folder / "control.sock";
  {  // bound, and closed without being removed: as after kill -9
    const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(socket);
  }
  LocalServer server(path);
  const Client client(path);
  client.say("anybody\n");
  server.serve(echo);
  EXPECT_EQ(client.hear(), "you said anybody\n");
}

TEST(LocalSocket, TakesNothingFromAProgramThatListensNorFromAFile) {
  Bench bench;
  EXPECT_THROW(LocalServer{bench.path}, InputError);
  EXPECT_TRUE(std::filesystem::exists(bench.path));
  const auto file = bench.folder / "file";
  std::ofstream(file) << "mine";
  EXPECT_THROW(LocalServer{file}, InputError);
  EXPECT_TRUE(std::filesystem::exists(file));
}

TEST(LocalSocket, RefusesNamesThatCanBeNone) {
  TemporaryFolder folder;
  EXPECT_THROW(LocalServer{folder / std::string(200, 'a')}, InputError);
  EXPECT_THROW(LocalServer{folder / "none" / "control.sock"}, InputError);
  EXPECT_THROW(LocalServer{""}, InputError);
}

TEST(LocalSocket, IsAskedByAnotherProgram) {
  Bench bench;
  std::string said;
  std::thread other([&] { said = ask(bench.path, "well?"); });
  while (bench.server.clients() == 0) bench.server.serve(echo);
  while (bench.server.clients() > 0) bench.server.serve(echo);
  other.join();
  EXPECT_EQ(said, "you said well?");
}

TEST(LocalSocket, SaysThatNobodyListensOrAnswers) {
  Bench bench;
  EXPECT_THROW(ask(bench.folder / "nobody", "?"), InputError);
  EXPECT_THROW(ask(bench.path, "?", seconds(0.01)), Error);
}

/// Sets a variable of the environment for a while.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    value ? ::setenv(name, value, 1) : ::unsetenv(name);
  }
  ~Variable() { old_.empty() ? ::unsetenv(name_) : ::setenv(name_, old_.c_str(), 1); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::string old_;
};

TEST(LocalSocket, IsInTheServicesFolderOrTheUsers) {
  const Variable user("XDG_RUNTIME_DIR", "/run/user/1000");
  {
    const Variable service("RUNTIME_DIRECTORY", "/run/headway");
    EXPECT_EQ(own_socket(), "/run/headway/control.sock");
  }
  const Variable service("RUNTIME_DIRECTORY", nullptr);
  EXPECT_EQ(own_socket(), "/run/user/1000/headway.sock");
  EXPECT_EQ(known_sockets(),
            (std::vector<std::filesystem::path>{"/run/user/1000/headway.sock", "/run/headway/control.sock"}));
}

}  // namespace
}  // namespace headway::app
