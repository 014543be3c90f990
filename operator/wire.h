// One connection's bytes, with or without TLS, as one type: so all that is built upon it is compiled once.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>

namespace headway::remote {

class Wire {
 public:
  using executor_type = boost::beast::tcp_stream::executor_type;
  using next_layer_type = boost::beast::tcp_stream;

  explicit Wire(boost::asio::ip::tcp::socket socket) : parts_(std::make_unique<Parts>(std::move(socket))) {}

  executor_type get_executor() noexcept { return parts_->tcp.get_executor(); }
  next_layer_type& next_layer() noexcept { return parts_->tcp; }
  const next_layer_type& next_layer() const noexcept { return parts_->tcp; }

  bool has_tls() const noexcept { return parts_->tls.has_value(); }
  /// All that is read and written from now on. `heard`: what was read before. The context must outlive it.
  template <class Buffers, class Handler>
  void async_begin_tls(boost::asio::ssl::context& context, const Buffers& heard, Handler&& handler) {
    parts_->tls.emplace(parts_->tcp, context);
    parts_->tls->async_handshake(boost::asio::ssl::stream_base::server, heard,
                                 std::forward<Handler>(handler));
  }
  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    if (parts_->tls)
      parts_->tls->async_read_some(buffers, std::forward<Handler>(handler));
    else
      parts_->tcp.async_read_some(buffers, std::forward<Handler>(handler));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    if (parts_->tls)
      parts_->tls->async_write_some(buffers, std::forward<Handler>(handler));
    else
      parts_->tcp.async_write_some(buffers, std::forward<Handler>(handler));
  }

 private:
  struct Parts {
    explicit Parts(boost::asio::ip::tcp::socket socket) : tcp(std::move(socket)) {}
    boost::beast::tcp_stream tcp;
    std::optional<boost::asio::ssl::stream<boost::beast::tcp_stream&>> tls;
  };
  std::unique_ptr<Parts> parts_;  ///< in one place, for TLS holds on to the other
};

// How Beast ends the connection under a WebSocket. TLS needs no word of its own: the WebSocket has said that
// it closes, and an HTTP answer says how long it is.
template <class Handler>
void async_teardown(boost::beast::role_type role, Wire& wire, Handler&& handler) {
  boost::beast::websocket::async_teardown(role, wire.next_layer().socket(), std::forward<Handler>(handler));
}
inline void teardown(boost::beast::role_type role, Wire& wire, boost::beast::error_code& fault) {
  boost::beast::websocket::teardown(role, wire.next_layer().socket(), fault);
}

}  // namespace headway::remote
