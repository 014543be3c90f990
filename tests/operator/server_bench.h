// A server, its main loop, and clients that know the bytes: for tests of what bad ones may do.
#pragma once

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "hal/clock.h"
#include "hal/error.h"
#include "operator/access.h"
#include "operator/foxglove.h"
#include "operator/http.h"
#include "operator/server.h"

namespace headway::remote {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Json = nlohmann::json;
using testing::HasSubstr;

inline constexpr Duration kPatience = seconds(20);

/// Messages of a chosen size, a new one of each channel whenever it is looked at.
class Flow final : public Source {
 public:
  void look(const Wanted&) override {
    for (std::size_t i = 0; i < kChannels.size(); ++i) {
      if (i != static_cast<std::size_t>(Channel::kPicture) && newest_[i].number > 0) continue;
      newest_[i].cdr = std::make_shared<const std::vector<std::byte>>(size_);
      ++newest_[i].number;
    }
    ++number_;
  }
  Newest newest(Channel channel) const override { return newest_[static_cast<std::size_t>(channel)]; }
  std::uint32_t status_number() const override { return number_; }
  std::shared_ptr<const std::vector<std::byte>> voxels(std::uint64_t& version) override {
    return std::exchange(version, 1) == 0 ? std::make_shared<const std::vector<std::byte>>(100) : nullptr;
  }
  std::shared_ptr<const std::string> file(const std::string& name) override {
    return name == "map.pgm" ? std::make_shared<const std::string>("P5") : nullptr;
  }
  std::string metrics() override { return "headway_up 1\n"; }

  std::size_t size_ = 1000;

 private:
  std::array<Newest, kChannels.size()> newest_;
  std::uint32_t number_ = 0;
};

inline constexpr unsigned char kPicture[] = {0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 2, 3,
                                             3,    0,    0, 0, 0, 0, 0, 0, 0, 0};
inline const PageFile kPage[] = {{"/index.html", "text/html; charset=utf-8", "\"1\"", kPicture}};

/// A server, and the main loop that answers when it is asked to.
class ServerTest : public testing::Test {
 protected:
  void begin_with_token() {
    ServerConfig config;
    config.require_token = true;
    begin(config);
  }
  void begin(ServerConfig config = {}) {
    config.port = 0;
    config.page = kPage;
    if (config.require_token) config.token_file = folder_ / "tokens";
    server_.emplace(config, flow_, clock_);
    if (config.require_token) tokens_ = tokens_in(config.token_file);
  }
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / fmt::format("headway_server_{}", ::getpid());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }
  void serve() {
    server_->serve([this](const Ask& ask) {
      asked_.push_back(ask);
      return std::string(R"({"ok":true})");
    });
  }
  bool was_asked(const std::string& service) const {
    return std::ranges::any_of(asked_, [&](const Ask& ask) { return ask.service == service; });
  }
  template <class Done>
  bool until(const Done& done) {
    for (const Time end = clock_.now() + kPatience; clock_.now() < end;) {
      if (done()) return true;
      clock_.sleep_until(clock_.now() + seconds(0.005));
    }
    return done();
  }

  hal::MonotonicClock clock_;
  Flow flow_;
  std::filesystem::path folder_;
  Tokens tokens_;
  std::vector<Ask> asked_;
  std::optional<Server> server_;
};

/// A plain TCP client.
struct Raw {
  explicit Raw(const Server& server) : socket(io) {
    socket.connect({asio::ip::make_address("127.0.0.1"), server.port()});
  }
  void send(const std::string& text) {
    beast::error_code ignored;
    asio::write(socket, asio::buffer(text), ignored);
  }
  /// All up to the end of the connection, or the first so many bytes.
  std::string receive(std::size_t most = 1 << 20) {
    std::string all(most, 0);
    beast::error_code ignored;
    all.resize(asio::read(socket, asio::buffer(all), asio::transfer_at_least(most), ignored));
    return all;
  }
  asio::io_context io;
  tcp::socket socket;
};

using Fields = std::vector<std::pair<std::string, std::string>>;

inline Response request(const Server& server, http::verb verb, const std::string& target,
                        const Fields& fields = {}, const std::string& body = "") {
  Raw raw(server);
  Request request{verb, target, 11};
  request.set(http::field::host, fmt::format("127.0.0.1:{}", server.port()));
  for (const auto& [key, value] : fields) request.set(key, value);
  request.body() = body;
  request.keep_alive(false);
  request.prepare_payload();
  http::write(raw.socket, request);
  beast::flat_buffer buffer;
  Response response;
  http::read(raw.socket, buffer, response);
  return response;
}
inline int code(const Server& server, http::verb verb, const std::string& target, const Fields& fields = {},
                const std::string& body = "") {
  return request(server, verb, target, fields, body).result_int();
}

/// What a request to become a WebSocket is answered.
inline int upgrade(const Server& server, const Fields& fields = {}, const std::string& target = "/ws",
                   const std::string& protocol = "foxglove.websocket.v1") {
  Fields all{{"Connection", "Upgrade"},
             {"Upgrade", "websocket"},
             {"Sec-WebSocket-Version", "13"},
             {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="}};
  if (!protocol.empty()) all.emplace_back("Sec-WebSocket-Protocol", protocol);
  all.insert(all.end(), fields.begin(), fields.end());
  return code(server, http::verb::get, target, all);
}

/// A WebSocket client that knows the protocol's bytes.
struct Talker {
  explicit Talker(const Server& server, const Fields& fields = {}, const std::string& target = "/ws",
                  const std::string& protocol = "foxglove.websocket.v1")
      : socket(io) {
    beast::get_lowest_layer(socket).connect({asio::ip::make_address("127.0.0.1"), server.port()});
    socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      if (!protocol.empty()) request.set(http::field::sec_websocket_protocol, protocol);
      for (const auto& [key, value] : fields) request.set(key, value);
    }));
    socket.handshake(answer, fmt::format("127.0.0.1:{}", server.port()), target, refused);
    if (refused) return;
    for (int i = 0; i < 3; ++i) hear();  // what there is
  }
  /// The next message; its text, or its bytes as they are. Empty when the connection has ended.
  std::string hear() {
    beast::flat_buffer buffer;
    socket.read(buffer, ended);
    return ended ? "" : beast::buffers_to_string(buffer.data());
  }
  void say(const std::string& text) {
    socket.text(true);
    socket.write(asio::buffer(text), ended);
  }
  void say_bytes(const std::string& bytes) {
    socket.binary(true);
    socket.write(asio::buffer(bytes), ended);
  }
  static std::string call_bytes(std::uint32_t service, std::uint32_t id, const std::string& body) {
    std::string out(1, '\2');
    for (const std::uint32_t word : {service, id, std::uint32_t{4}})
      out.append(reinterpret_cast<const char*>(&word), sizeof word);
    return out + "json" + body;
  }
  static std::uint32_t service(std::string_view name) {
    for (std::uint32_t i = 0; i < foxglove::kServices.size(); ++i)
      if (foxglove::kServices[i].name == name) return i;
    return 999;
  }
  void call(std::string_view name, const std::string& body = "{}") {
    say_bytes(call_bytes(service(name), ++last, body));
  }
  /// The answer to the newest call, whatever else comes before it.
  Json answered() {
    for (;;) {
      const std::string text = hear();
      if (text.empty()) return nullptr;
      if (text[0] == '\3' && text.size() > 17) return Json::parse(text.substr(17));
      if (text[0] == '{') {
        const Json said = Json::parse(text);
        if (said.at("op") == "serviceCallFailure") return said;
      }
    }
  }
  /// The next status that it is told.
  std::string told() {
    for (;;) {
      const std::string text = hear();
      if (text.empty()) return "";
      if (text[0] == '{' && Json::parse(text).at("op") == "status") return Json::parse(text).at("message");
    }
  }

  asio::io_context io;
  websocket::stream<beast::tcp_stream> socket;
  websocket::response_type answer;
  beast::error_code refused, ended;
  std::uint32_t last = 0;
};

}  // namespace headway::remote
