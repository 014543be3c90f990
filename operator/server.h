// The operator's server: HTTP and WebSocket on one port, in one thread that shares nothing with the loops but
// newest values and two queues.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/clock.h"
#include "operator/lease.h"
#include "operator/messages.h"
#include "operator/page_files.h"
#include "operator/source.h"
#include "operator/tls.h"

namespace headway::remote {

struct ServerConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8760;         ///< 0: any that is free
  std::vector<std::string> names;    ///< other than addresses, that browsers may know it by
  bool require_token = false;        ///< any address but a loopback's asks for one anyway
  std::filesystem::path token_file;  ///< made where it is missing
  std::optional<TlsFiles> tls;       ///< nothing: nothing is encrypted
  std::string robot = "robot";
  std::span<const PageFile> page;
  std::size_t most_clients = 8;
};

/// What a client has called for, allowed and well-formed, to be done by the main loop.
struct Ask {
  std::uint64_t client = 0;
  std::string name, service;
  std::string body;          ///< a JSON object
  std::uint64_t number = 0;  ///< the server's own
};

struct ServerFigures {
  std::uint32_t clients = 0;
  std::uint64_t messages = 0, dropped = 0, refused = 0, calls = 0;
};

class Server {
 public:
  /// Listens from now on. Source and clock must outlive it. Throws InputError for an address or a port that
  /// cannot be listened at, and as tokens_in() and tls_context().
  Server(const ServerConfig& config, Source& source, const hal::Clock& clock);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// In the main loop's thread, often: answers all that clients have asked since, each with a JSON object.
  /// Never waits. Stops come first, and of the rest a few with each call. "lease" comes from the server
  /// itself, {"lease": n (0: nobody's), "released": times that one was given up, "age_ns": since it was
  /// heard}.
  void serve(const std::function<std::string(const Ask&)>& answer);

  std::uint16_t port() const;
  /// With the operator's token where one is needed.
  std::string address_to_open() const;
  Lease::Holder holder() const;
  ServerFigures figures() const;
  /// As of half a second ago at most. In one thread.
  const std::vector<ViewerStatus>& viewers() const;

 private:
  class Room;
  std::unique_ptr<Room> room_;
};

}  // namespace headway::remote
