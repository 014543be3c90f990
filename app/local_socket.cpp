#include "app/local_socket.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::app {

namespace {

constexpr const char* kMachine = "/run/headway/control.sock";

/// A socket that is closed at the end of its scope, unless it is released.
class Socket {
 public:
  explicit Socket(int flags) : descriptor_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | flags, 0)) {
    if (descriptor_ < 0) throw Error(fmt::format("no socket can be opened: {}", std::strerror(errno)));
  }
  ~Socket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int get() const { return descriptor_; }
  int release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_;
};

sockaddr_un address_of(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string& name = path.native();
  if (name.empty() || name.size() >= sizeof address.sun_path)
    throw InputError(
        fmt::format("{}: no name of a socket, expected 1 to {} bytes", name, sizeof address.sun_path - 1));
  std::memcpy(address.sun_path, name.c_str(), name.size());
  return address;
}

int connect_to(int socket, const sockaddr_un& address) {
  return ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

int bind_to(int socket, const sockaddr_un& address) {
  return ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

bool is_socket_file(const std::filesystem::path& path) {
  struct stat file {};
  return ::lstat(path.c_str(), &file) == 0 && S_ISSOCK(file.st_mode);
}

/// Whether the file is a socket that nobody listens at any more.
bool left_behind(const std::filesystem::path& path, const sockaddr_un& address) {
  const Socket probe(SOCK_NONBLOCK);
  return is_socket_file(path) && connect_to(probe.get(), address) != 0 && errno == ECONNREFUSED;
}

std::optional<std::string> variable(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr || *value == 0) return std::nullopt;
  return value;
}

std::optional<std::filesystem::path> user_socket() {
  if (const auto folder = variable("XDG_RUNTIME_DIR")) return std::filesystem::path(*folder) / "headway.sock";
  return std::nullopt;
}

}  // namespace

std::filesystem::path own_socket() {
  if (const auto service = variable("RUNTIME_DIRECTORY"))
    return std::filesystem::path(*service) / "control.sock";
  if (const auto user = user_socket()) return *user;
  if (::geteuid() == 0) return kMachine;
  return {};
}

std::vector<std::filesystem::path> known_sockets() {
  std::vector<std::filesystem::path> paths;
  if (const auto user = user_socket()) paths.push_back(*user);
  paths.emplace_back(kMachine);
  return paths;
}

LocalServer::LocalServer(std::filesystem::path path) : path_(std::move(path)) {
  const sockaddr_un address = address_of(path_);
  std::error_code ignored;
  if (path_ == kMachine) std::filesystem::create_directory(path_.parent_path(), ignored);
  Socket socket(SOCK_NONBLOCK);
  int bound = bind_to(socket.get(), address);
  if (bound != 0 && errno == EADDRINUSE) {
    if (!left_behind(path_, address))
      throw InputError(
          fmt::format("{}: another program listens there, or it is no socket; end that one, or name another "
                      "with --socket",
                      path_.native()));
    ::unlink(path_.c_str());
    bound = bind_to(socket.get(), address);
  }
  if (bound != 0)
    throw InputError(fmt::format("{}: no socket can be made there ({}); name another place with --socket",
                                 path_.native(), std::strerror(errno)));
  // The owner and the group: the robot's operators.
  ::chmod(path_.c_str(), S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP);
  if (::listen(socket.get(), static_cast<int>(kMostClients)) != 0) {
    const int fault = errno;
    ::unlink(path_.c_str());
    throw Error(fmt::format("{}: cannot listen ({})", path_.native(), std::strerror(fault)));
  }
  socket_ = socket.release();
}

LocalServer::~LocalServer() {
  for (const Client& client : clients_) ::close(client.socket);
  ::unlink(path_.c_str());
  ::close(socket_);
}

void LocalServer::serve(const std::function<std::string(std::string_view line)>& answer) {
  accept_all();
  std::erase_if(clients_, [&](Client& client) {
    if (attend(client, answer)) return false;
    ::close(client.socket);
    return true;
  });
}

void LocalServer::accept_all() {
  for (std::size_t i = 0; i < kMostClients; ++i) {
    const int socket = ::accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    if (clients_.size() == kMostClients) {
      ::close(clients_.front().socket);
      clients_.erase(clients_.begin());
    }
    clients_.push_back({socket, {}, {}});
  }
}

/// False when there is nothing more to say to it.
bool LocalServer::attend(Client& client, const std::function<std::string(std::string_view)>& answer) {
  std::array<char, kLongestLine> bytes;
  const ssize_t got = ::recv(client.socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (got < 0 && errno != EAGAIN && errno != EINTR) return false;
  if (got > 0) client.heard.append(bytes.data(), static_cast<std::size_t>(got));
  std::size_t begin = 0;
  for (std::size_t end; (end = client.heard.find('\n', begin)) != std::string::npos; begin = end + 1) {
    if (client.unsaid.size() > kLongestWait) return false;
    client.unsaid += answer(std::string_view(client.heard).substr(begin, end - begin)) + "\n";
  }
  client.heard.erase(0, begin);
  if (client.heard.size() > kLongestLine) return false;
  if (!client.unsaid.empty()) {
    const ssize_t sent =
        ::send(client.socket, client.unsaid.data(), client.unsaid.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) return false;
    if (sent > 0) client.unsaid.erase(0, static_cast<std::size_t>(sent));
  }
  return got != 0;  // 0: it has said all that it wanted
}

bool listens(const std::filesystem::path& path) {
  const Socket probe(SOCK_NONBLOCK);
  // EAGAIN: as many wait as may.
  return is_socket_file(path) && (connect_to(probe.get(), address_of(path)) == 0 || errno == EAGAIN);
}

std::string ask(const std::filesystem::path& path, std::string_view line, Duration longest) {
  const Socket socket(0);
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(longest);
  const timeval patience{whole.count(),
                         std::chrono::duration_cast<std::chrono::microseconds>(longest - whole).count()};
  ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  if (connect_to(socket.get(), address_of(path)) != 0)
    throw InputError(
        fmt::format("{}: no running program listens there ({})", path.native(), std::strerror(errno)));
  const std::string question = std::string(line) + "\n";
  if (::send(socket.get(), question.data(), question.size(), MSG_NOSIGNAL) !=
      static_cast<ssize_t>(question.size()))
    throw Error(fmt::format("{}: hung up ({})", path.native(), std::strerror(errno)));
  std::string answer;
  std::array<char, 4096> bytes;
  while (answer.find('\n') == std::string::npos) {
    pollfd ready{socket.get(), POLLIN, 0};
    const int so = ::poll(&ready, 1, static_cast<int>(to_seconds(longest) * 1000));
    if (so == 0) throw Error(fmt::format("{}: no answer within {:g} s", path.native(), to_seconds(longest)));
    const ssize_t got = so < 0 ? -1 : ::recv(socket.get(), bytes.data(), bytes.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw Error(fmt::format("{}: hung up without an answer", path.native()));
    answer.append(bytes.data(), static_cast<std::size_t>(got));
  }
  return answer.substr(0, answer.find('\n'));
}

}  // namespace headway::app
