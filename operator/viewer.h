// One WebSocket client: what it has subscribed to, what it has been told, and what it asks for. Of each
// channel it has the newest message or waits for it: nothing queues up for who reads slowly.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include "operator/access.h"
#include "operator/foxglove.h"
#include "operator/http.h"
#include "operator/source.h"
#include "operator/wire.h"

namespace headway::remote {

class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  static constexpr std::size_t kMostWaiting = 1u << 20;   ///< of answers that it has not read [bytes]
  static constexpr std::size_t kLongestHeard = 1u << 20;  ///< of a message that it sends [bytes]
  static constexpr int kMostNotes = 100;                  ///< of what it did wrong; who goes on is hung up on

  /// What a viewer needs of the server; called in its thread.
  struct Host {
    std::function<void(Viewer&, const foxglove::Call&)> call;
    std::function<std::uint64_t(Channel)> newest;  ///< number of the newest message
    std::function<void(Viewer&)> gone;
  };
  Viewer(Wire wire, std::uint64_t number, Role role, Host host);

  /// Shakes hands and tells what there is. The request must be an upgrade with one of our subprotocols.
  void accept(const Request& request, const std::string& robot, const std::string& session);
  void close(const std::string& why);

  /// Sends what is newer than what it had, one message after the other.
  void send_news(Source& source);
  /// Of the channels that it has subscribed to.
  void want(Wanted& wanted) const;
  void say(std::string text);
  void respond(const foxglove::Call& call, const std::string& json);

  std::uint64_t number() const { return number_; }
  Role role() const { return role_; }
  std::uint64_t sent() const { return sent_; }
  /// Messages that it was too slow for, also while it still reads the one before them.
  std::uint64_t missed(const Source& source) const;
  const std::string& address() const { return address_; }
  std::string name;  ///< as it called itself when it took control

 private:
  struct Subscription {
    Channel channel{};
    std::uint64_t last = 0;  ///< number of the message that it had last; of voxels their version
  };
  void listen();
  void hear();
  bool bears();
  void note(const std::string& fault);
  void queue(std::vector<std::byte> bytes, bool text);
  void write_queued();
  bool write_newest(Source& source);
  void written(boost::beast::error_code fault);
  void end();

  boost::beast::websocket::stream<Wire> socket_;
  const std::uint64_t number_;
  const Role role_;
  std::string address_;
  Host host_;
  boost::beast::flat_buffer heard_;
  Request request_;
  std::map<std::uint32_t, Subscription> subscriptions_;
  std::uint32_t served_last_ = 0;  ///< the subscription that got a message last: the next one is another's
  struct Waiting {
    std::vector<std::byte> bytes;
    bool text = false;
  };
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  bool open_ = false, writing_ = false, ended_ = false, closing_ = false;
  int notes_ = 0;
  // Of the write under way:
  std::array<std::byte, 13> head_{};
  std::shared_ptr<const std::vector<std::byte>> body_;
  std::uint64_t sent_ = 0, dropped_ = 0;
};

}  // namespace headway::remote
