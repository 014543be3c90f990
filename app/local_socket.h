// Lines asked and answered between programs of one machine: how a running program is looked at and told where
// to go. A socket in the file system, so the file's permissions say who may.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/time.h"

namespace headway::app {

/// Where a running program listens unless told otherwise: in the service's folder, in the machine's (for
/// root), or in the user's own; empty where there is none of them.
std::filesystem::path own_socket();
/// Where one is looked for, in this order: the user's own, the service's.
std::vector<std::filesystem::path> known_sockets();

/// Listens; serves whoever asks. Never waits for anybody: it is called between two looks at the loops.
class LocalServer {
 public:
  static constexpr std::size_t kMostClients = 8;
  static constexpr std::size_t kLongestLine = 4096;      ///< of a question, in bytes
  static constexpr std::size_t kLongestWait = 1u << 18;  ///< answers that a client has not read, in bytes

  /// A name left behind by a program that is gone is taken over. Throws InputError where the path cannot be
  /// one, or another program listens there; Error where the system refuses.
  explicit LocalServer(std::filesystem::path path);
  ~LocalServer();
  LocalServer(const LocalServer&) = delete;
  LocalServer& operator=(const LocalServer&) = delete;

  /// Answers each line that has come, with a line. Who sends lines without end or does not read is hung up
  /// on; when there are too many, whoever came first makes room.
  void serve(const std::function<std::string(std::string_view line)>& answer);

  const std::filesystem::path& path() const { return path_; }
  std::size_t clients() const { return clients_.size(); }

 private:
  struct Client {
    int socket;
    std::string heard, unsaid;
  };
  void accept_all();
  static bool attend(Client& client, const std::function<std::string(std::string_view)>& answer);

  std::filesystem::path path_;
  int socket_ = -1;
  std::vector<Client> clients_;
};

/// Whether a program listens there.
bool listens(const std::filesystem::path& path);

/// The answer to `line` from the program that listens at `path`. Throws InputError where nobody listens,
/// Error where no whole line has come within `longest`.
std::string ask(const std::filesystem::path& path, std::string_view line, Duration longest = seconds(2));

}  // namespace headway::app
