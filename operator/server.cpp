#include "operator/server.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/detect_ssl.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "hal/error.h"
#include "hal/exchange.h"
#include "operator/access.h"
#include "operator/control.h"
#include "operator/foxglove.h"
#include "operator/http.h"
#include "operator/page_metrics.h"
#include "operator/viewer.h"
#include "runtime/threads.h"

namespace headway::remote {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using Json = nlohmann::json;

constexpr auto kLook = std::chrono::milliseconds(16);  // between two looks at the source
constexpr Duration kTellViewers = seconds(0.5);        // who looks on, and what he missed
constexpr auto kPatience = std::chrono::seconds(5);    // with who sends a request
constexpr auto kWrongToken = std::chrono::milliseconds(300);
constexpr std::size_t kLongestHead = 8 * 1024, kLongestBody = 4 * 1024, kMostConnections = 24;
constexpr std::ptrdiff_t kMostPending = 8;  // calls of one viewer; twice as many with stops
constexpr int kMostAtOnce = 2;              // asks that serve() answers in one call, besides what cannot wait
constexpr Duration kAnswered = seconds(2);  // by the main loop, else it is busy

std::string view(beast::string_view text) { return {text.data(), text.size()}; }

std::vector<std::string> names_of(const ServerConfig& config) {
  std::vector<std::string> names = config.names;
  beast::error_code fault;
  if (const std::string own = asio::ip::host_name(fault); !fault) names.push_back(own);
  return names;
}

asio::ip::address address_of(const ServerConfig& config) {
  beast::error_code fault;
  const auto address = asio::ip::make_address(config.address, fault);
  if (fault)
    throw InputError(fmt::format("--address {}: expected an IP address such as 127.0.0.1", config.address));
  return address;
}

}  // namespace

class Server::Room {
 public:
  Room(const ServerConfig& config, Source& source, const hal::Clock& clock)
      : config_(config),
        source_(source),
        clock_(clock),
        names_(names_of(config)),
        access_(tokens(config)),
        tls_(config.tls ? tls_context(*config.tls) : nullptr),
        session_(random_token().substr(0, 16)),
        acceptor_(io_),
        timer_(io_),
        control_(clock) {
    listen();
    thread_.emplace(runtime::ThreadId::kOperator, [this](const std::atomic<bool>& stop) { run(stop); });
  }

  void serve(const std::function<std::string(const Ask&)>& answer) {
    if (const Control::Word* word = control_.news()) answer(ask_of(*word));
    for (Ask ask; stops_.pop(ask);) answers_.push({ask.number, answer(ask)});
    Ask ask;
    for (int n = 0; n < kMostAtOnce && asks_.pop(ask); ++n) answers_.push({ask.number, answer(ask)});
  }
  std::uint16_t port() const { return port_; }
  std::string address_to_open() const {
    const bool v6 = config_.address.find(':') != std::string::npos;
    const std::string host = config_.address == "0.0.0.0" || config_.address == "::" ? asio::ip::host_name()
                             : v6 ? "[" + config_.address + "]"
                                  : config_.address;
    return fmt::format("{}://{}:{}/{}", tls_ ? "https" : "http", host, port_,
                       tokens_ ? "#token=" + tokens_->operate : "");
  }
  Lease::Holder holder() { return control_.holder(); }
  ServerFigures figures() const { return {clients_, messages_, dropped_, refused_, calls_}; }
  const std::vector<ViewerStatus>& viewers() {
    shown_viewers_.update();
    return shown_viewers_.value();
  }

 private:
  class Connection;
  struct Answer {
    std::uint64_t number = 0;
    std::string json;
  };
  Ask ask_of(const Control::Word& word) const {
    const Duration age = clock_.now() - word.at;
    return {0, "", "lease",
            Json{{"lease", word.number}, {"released", word.released}, {"age_ns", age.count()}}.dump(), 0};
  }
  struct Pending {
    std::weak_ptr<Viewer> viewer;
    foxglove::Call call;
    Time until{};
  };

  std::optional<Tokens> tokens(const ServerConfig& config) {
    if (config.require_token || !address_of(config).is_loopback()) tokens_ = tokens_in(config.token_file);
    return tokens_;
  }
  void listen();
  void accept_next();
  void run(const std::atomic<bool>& stop);
  void look_around(const std::atomic<bool>& stop);
  void show_viewers();
  std::vector<ViewerStatus> viewer_statuses() const;
  /// Those of the robot, and the server's own.
  std::string metrics() const { return source_.metrics() + page_metrics(figures(), viewer_statuses()); }
  void deliver_answers();
  Response answer(const Request& request);
  Response log_in(const Request& request);
  std::optional<Response> refused(const Request& request);
  std::optional<Response> refused_upgrade(const Request& request);
  Response only_encrypted(const Request& request) const;
  void upgrade(Wire wire, const Request& request);
  void call(Viewer& viewer, const foxglove::Call& call);
  std::optional<std::string> answered_here(Viewer& viewer, std::string_view service, const Json& body);
  void pass_on(Viewer& viewer, const foxglove::Call& call, const std::string& service);

  ServerConfig config_;
  Source& source_;
  const hal::Clock& clock_;
  std::optional<Tokens> tokens_;
  const std::vector<std::string> names_;
  Access access_;
  std::unique_ptr<asio::ssl::context> tls_;  ///< null: nothing is encrypted
  std::string session_;
  asio::io_context io_{1};
  tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  std::uint16_t port_ = 0;
  std::size_t connections_ = 0;
  std::map<std::uint64_t, std::shared_ptr<Viewer>> viewers_;
  std::uint64_t last_viewer_ = 0, last_ask_ = 0;
  Control control_;
  std::map<std::uint64_t, Pending> pending_;
  hal::BoundedQueue<Ask, 64> stops_;
  hal::BoundedQueue<Ask, 256> asks_;
  hal::BoundedQueue<Answer, 256> answers_;
  hal::NewestSlot<std::vector<ViewerStatus>> shown_viewers_;
  Time viewers_shown_at_{};
  std::uint64_t gone_messages_ = 0, gone_dropped_ = 0;
  std::atomic<std::uint32_t> clients_{0};
  std::atomic<std::uint64_t> messages_{0}, dropped_{0}, refused_{0}, calls_{0};
  std::optional<runtime::Thread> thread_;
};

/// One that has asked for no upgrade yet: requests, one after the other.
class Server::Room::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Room& room) : wire_(std::move(socket)), room_(room) { ++room_.connections_; }
  ~Connection() { --room_.connections_; }

  /// Encrypted or not: where all is to be, what is not gets an answer that says so.
  void start() {
    if (!room_.tls_) return read();
    wire_.next_layer().expires_after(kPatience);
    beast::async_detect_ssl(wire_.next_layer(), buffer_,
                            [self = shared_from_this()](beast::error_code fault, bool encrypted) {
                              if (fault) return self->refused();
                              encrypted ? self->begin_tls() : self->read();
                            });
  }

 private:
  void refused() { ++room_.refused_; }
  void begin_tls() {
    wire_.async_begin_tls(*room_.tls_, buffer_.data(),
                          [self = shared_from_this()](beast::error_code fault, std::size_t used) {
                            if (fault) return self->refused();
                            self->buffer_.consume(used);
                            self->read();
                          });
  }
  void read() {
    parser_.emplace();
    parser_->header_limit(kLongestHead);
    parser_->body_limit(kLongestBody);
    wire_.next_layer().expires_after(kPatience);
    http::async_read(wire_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code fault, std::size_t) {
                       if (!fault) return self->handle();
                       ++self->room_.refused_;
                       if (fault == http::error::header_limit || fault == http::error::body_limit)
                         self->refuse("the request is too long\n");
                     });
  }
  void handle() {
    const Request request = parser_->release();
    if (room_.tls_ && !wire_.has_tls()) return write(room_.only_encrypted(request));
    if (boost::beast::websocket::is_upgrade(request) && !room_.refused(request)) {
      auto no = room_.refused_upgrade(request);
      return no ? write(*std::move(no)) : room_.upgrade(std::move(wire_), request);
    }
    Response response = room_.answer(request);
    if (response.result() != http::status::unauthorized || request.method() != http::verb::post)
      return write(std::move(response));
    delay_.emplace(wire_.get_executor(), kWrongToken);  // so that guessing takes its time
    delay_->async_wait([self = shared_from_this(), response = std::move(response)](
                           beast::error_code) mutable { self->write(std::move(response)); });
  }
  void refuse(const std::string& why) {
    Response response{http::status::payload_too_large, 11};
    response.body() = why;
    response.keep_alive(false);
    response.prepare_payload();
    write(std::move(response));
  }
  void write(Response response) {
    response_ = std::move(response);
    wire_.next_layer().expires_after(kPatience);
    http::async_write(wire_, response_, [self = shared_from_this()](beast::error_code fault, std::size_t) {
      if (fault) return;
      if (self->response_.keep_alive()) return self->read();
      beast::error_code ignored;
      self->wire_.next_layer().socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  Wire wire_;
  Room& room_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<asio::steady_timer> delay_;
  Response response_;
};

void Server::Room::listen() {
  beast::error_code fault;
  const tcp::endpoint at(address_of(config_), config_.port);
  acceptor_.open(at.protocol(), fault);
  if (!fault) acceptor_.set_option(asio::socket_base::reuse_address(true), fault);
  if (!fault) acceptor_.bind(at, fault);
  if (!fault) acceptor_.listen(asio::socket_base::max_listen_connections, fault);
  if (fault)
    throw InputError(fmt::format("{} port {}: {}; --port names another, 0 any that is free", config_.address,
                                 config_.port, fault.message()));
  port_ = acceptor_.local_endpoint().port();
}

void Server::Room::run(const std::atomic<bool>& stop) {
  accept_next();
  look_around(stop);
  while (!io_.stopped()) {
    try {
      io_.run();
    } catch (const std::exception&) {  // of one client: the others go on
      ++refused_;
    }
  }
}

void Server::Room::accept_next() {
  acceptor_.async_accept([this](beast::error_code fault, tcp::socket socket) {
    if (!fault && connections_ < kMostConnections)
      std::make_shared<Connection>(std::move(socket), *this)->start();
    else
      ++refused_;
    accept_next();
  });
}

void Server::Room::look_around(const std::atomic<bool>& stop) {
  if (stop) return io_.stop();
  timer_.expires_after(kLook);
  timer_.async_wait([this, &stop](beast::error_code) { look_around(stop); });
  Wanted wanted{};
  for (const auto& [number, viewer] : viewers_) viewer->want(wanted);
  try {
    source_.look(wanted);
  } catch (const std::exception&) {  // a picture that cannot be shown costs nobody the rest
    ++refused_;
  }
  control_.look(source_.status_number());
  deliver_answers();
  std::uint64_t messages = gone_messages_, dropped = gone_dropped_;
  for (const auto& [number, viewer] : std::map(viewers_)) {
    viewer->send_news(source_);
    messages += viewer->sent();
    dropped += viewer->missed(source_);
  }
  clients_ = static_cast<std::uint32_t>(viewers_.size());
  messages_ = messages;
  dropped_ = dropped;
  show_viewers();
}

std::vector<ViewerStatus> Server::Room::viewer_statuses() const {
  std::vector<ViewerStatus> all;
  for (const auto& [number, viewer] : viewers_)
    all.push_back({.number = static_cast<std::uint32_t>(number),
                   .name = viewer->name,
                   .role = name(viewer->role()),
                   .address = viewer->address(),
                   .has_control = control_.holds(number),
                   .sent = viewer->sent(),
                   .missed = viewer->missed(source_)});
  return all;
}

void Server::Room::show_viewers() {
  const Time now = clock_.now();
  if (now - viewers_shown_at_ < kTellViewers) return;
  viewers_shown_at_ = now;
  shown_viewers_.publish(viewer_statuses());
}

std::optional<Response> Server::Room::refused(const Request& request) {
  const std::string host = view(request[http::field::host]), origin = view(request[http::field::origin]);
  if (!is_our_host(host, config_.address, names_))
    return respond(request, http::status::misdirected_request,
                   "this server is not known by that name; open it by its address\n");
  if (!origin.empty() && !is_our_origin(origin, host))
    return respond(request, http::status::forbidden, "pages of other servers may not use this one\n");
  return std::nullopt;
}

Response Server::Room::answer(const Request& request) {
  if (auto no = refused(request)) {
    ++refused_;
    return *std::move(no);
  }
  if (request.target() == "/login") return log_in(request);
  const Role role = access_.role_of(view(request[http::field::cookie]));
  if (request.target() == "/session")
    return respond(request, http::status::ok,
                   Json{{"role", name(role)}, {"token_needed", access_.needs_token()}}.dump(),
                   "application/json");
  if (role == Role::kNone && !is_open_to_all(request, config_.page))
    return respond(request, http::status::unauthorized, "open the page with its token first\n");
  if (request.target() == "/ws")
    return respond(request, http::status::upgrade_required, "expected a WebSocket\n");
  return get(request, config_.page, source_, [this] { return metrics(); });
}

Response Server::Room::log_in(const Request& request) {
  if (request.method() != http::verb::post)
    return respond(request, http::status::method_not_allowed, "expected POST\n");
  if (!view(request[http::field::content_type]).starts_with("application/json"))
    return respond(request, http::status::unsupported_media_type, "expected application/json\n");
  const Json body = Json::parse(request.body(), nullptr, false);
  const auto token = body.is_object() ? body.find("token") : body.end();
  if (!body.is_object() || token == body.end() || !token->is_string())
    return respond(request, http::status::bad_request, "expected {\"token\": \"...\"}\n");
  const auto login = access_.log_in(token->get<std::string>(), clock_.now());
  using Outcome = Access::Login::Outcome;
  if (login.outcome != Outcome::kIn) ++refused_;
  if (login.outcome == Outcome::kTooOften)
    return respond(request, http::status::too_many_requests, "too many wrong tokens; wait a while\n");
  if (login.outcome == Outcome::kWrong)
    return respond(request, http::status::unauthorized, "that is not the token\n");
  Response in = respond(request, http::status::no_content, "");
  if (!login.cookie.empty())
    in.set(http::field::set_cookie,
           login.cookie + "; HttpOnly; SameSite=Strict; Path=/" + (tls_ ? "; Secure" : ""));
  return in;
}

/// What was asked for in the clear may have carried a token: it is not even looked at.
Response Server::Room::only_encrypted(const Request& request) const {
  const std::string host = view(request[http::field::host]);
  const bool ours = is_our_host(host, config_.address, names_);
  Response no =
      respond(request, http::status::bad_request,
              fmt::format("this server is encrypted: open https://{}\n", ours ? host + "/" : "..."));
  no.keep_alive(false);
  return no;
}

std::optional<Response> Server::Room::refused_upgrade(const Request& request) {
  const auto turn_away = [&](http::status status, const std::string& why) {
    ++refused_;
    Response no = respond(request, status, why);
    no.keep_alive(false);
    return no;
  };
  const Role role = access_.role_of(view(request[http::field::cookie]));
  if (request.target() != "/ws") return turn_away(http::status::not_found, "expected /ws\n");
  if (role == Role::kNone)
    return turn_away(http::status::unauthorized, "open the page with its token first\n");
  const std::string offered = view(request[http::field::sec_websocket_protocol]);
  if (offered.find(foxglove::kSubprotocols[0]) == std::string::npos &&
      offered.find(foxglove::kSubprotocols[1]) == std::string::npos)
    return turn_away(http::status::bad_request,
                     "expected the subprotocol foxglove.websocket.v1 or foxglove.sdk.v1\n");
  if (viewers_.size() >= config_.most_clients)
    return turn_away(http::status::service_unavailable,
                     fmt::format("{} viewers are connected already; close one\n", config_.most_clients));
  return std::nullopt;
}

/// One that is not refused.
void Server::Room::upgrade(Wire wire, const Request& request) {
  const Role role = access_.role_of(view(request[http::field::cookie]));
  const std::uint64_t number = ++last_viewer_;
  const auto viewer = std::make_shared<Viewer>(
      std::move(wire), number, role,
      Viewer::Host{[this](Viewer& who, const foxglove::Call& what) { call(who, what); },
                   [this](Channel channel) { return source_.newest(channel).number; },
                   [this](Viewer& who) {
                     gone_messages_ += who.sent();
                     gone_dropped_ += who.missed(source_);
                     viewers_.erase(who.number());
                   }});
  viewers_[number] = viewer;
  viewer->accept(request, config_.robot, session_);
}

void Server::Room::call(Viewer& viewer, const foxglove::Call& call) {
  ++calls_;
  const foxglove::ServiceKind& kind = foxglove::kServices[call.service];
  using Needs = foxglove::ServiceKind::Needs;
  if (kind.needs != Needs::kNothing && viewer.role() != Role::kOperator)
    return viewer.respond(call, refusal("a viewer may look on, and stop the robot"));
  if (kind.needs == Needs::kControl && !control_.holds(viewer.number()))
    return viewer.respond(call, control_.refuse());
  const Json body = Json::parse(call.body, nullptr, false);
  if (const auto here = answered_here(viewer, kind.name, body)) return viewer.respond(call, *here);
  pass_on(viewer, call, std::string(kind.name));
}

std::optional<std::string> Server::Room::answered_here(Viewer& viewer, std::string_view service,
                                                       const Json& body) {
  if (service == "ping")
    return Json{{"ok", true}, {"now_ns", clock_.now().time_since_epoch().count()}}.dump();
  if (service == "take_control")
    return control_.take(viewer.number(), viewer.name = name_in(body, viewer.number()));
  if (service == "renew") return control_.renew(viewer.number(), body);
  if (service == "release_control") return control_.release(viewer.number());
  return std::nullopt;
}

void Server::Room::pass_on(Viewer& viewer, const foxglove::Call& call, const std::string& service) {
  const auto waits = std::ranges::count_if(
      pending_, [&](const auto& pending) { return pending.second.viewer.lock().get() == &viewer; });
  const bool stop = service == "stop";  // overtakes all else
  if (waits >= (stop ? 2 * kMostPending : kMostPending))
    return viewer.respond(call, refusal("too much is asked at once; wait a moment"));
  const std::uint64_t number = ++last_ask_;
  Ask ask{viewer.number(), viewer.name, service, call.body, number};
  if (!(stop ? stops_.push(std::move(ask)) : asks_.push(std::move(ask))))
    return viewer.respond(call, refusal("too much is asked at once; wait a moment"));
  pending_[number] = {viewer.weak_from_this(), call, clock_.now() + kAnswered};
}

void Server::Room::deliver_answers() {
  for (Answer answer; answers_.pop(answer);) {
    const auto found = pending_.find(answer.number);
    if (found == pending_.end()) continue;
    if (const auto viewer = found->second.viewer.lock()) viewer->respond(found->second.call, answer.json);
    pending_.erase(found);
  }
  std::erase_if(pending_, [&](const auto& pending) {
    if (clock_.now() < pending.second.until) return false;
    if (const auto viewer = pending.second.viewer.lock())
      viewer->say(foxglove::call_failure(pending.second.call.service, pending.second.call.id,
                                         "the program is busy and did not answer; what was asked for may yet "
                                         "be done"));
    return true;
  });
}

Server::Server(const ServerConfig& config, Source& source, const hal::Clock& clock)
    : room_(std::make_unique<Room>(config, source, clock)) {}
Server::~Server() = default;

void Server::serve(const std::function<std::string(const Ask&)>& answer) { room_->serve(answer); }
std::uint16_t Server::port() const { return room_->port(); }
std::string Server::address_to_open() const { return room_->address_to_open(); }
Lease::Holder Server::holder() const { return room_->holder(); }
ServerFigures Server::figures() const { return room_->figures(); }
const std::vector<ViewerStatus>& Server::viewers() const { return room_->viewers(); }

}  // namespace headway::remote
