#include "operator/viewer.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <fmt/format.h>

namespace headway::remote {

namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

/// The subprotocol of ours that the client offers; empty where it offers none.
std::string subprotocol(const Request& request) {
  const auto offered = request[beast::http::field::sec_websocket_protocol];
  for (const auto& one : beast::http::token_list(offered))
    for (const std::string_view ours : foxglove::kSubprotocols)
      if (std::string_view(one.data(), one.size()) == ours) return std::string(ours);
  return "";
}

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
  return {bytes, bytes + text.size()};
}

}  // namespace

Viewer::Viewer(Wire wire, std::uint64_t number, Role role, Host host)
    : socket_(std::move(wire)), number_(number), role_(role), host_(std::move(host)) {
  beast::error_code fault;
  const auto from = beast::get_lowest_layer(socket_).socket().remote_endpoint(fault);
  if (!fault) address_ = from.address().to_string();
}

void Viewer::accept(const Request& request, const std::string& robot, const std::string& session) {
  beast::get_lowest_layer(socket_).expires_never();
  websocket::stream_base::timeout times{};
  times.handshake_timeout = std::chrono::seconds(5);
  times.idle_timeout = std::chrono::seconds(15);
  times.keep_alive_pings = true;
  socket_.set_option(times);
  socket_.read_message_max(kLongestHeard);
  const std::string protocol = subprotocol(request);
  socket_.set_option(websocket::stream_base::decorator([protocol](websocket::response_type& response) {
    response.set(beast::http::field::server, "Headway");
    response.set(beast::http::field::sec_websocket_protocol, protocol);
  }));
  request_ = request;  // must last as long as the handshake
  socket_.async_accept(request_, [self = shared_from_this(), robot, session](beast::error_code fault) {
    if (fault) return self->end();
    self->open_ = true;
    self->say(foxglove::server_info(robot, session, remote::name(self->role_), self->number_));
    self->say(foxglove::advertise_channels());
    self->say(foxglove::advertise_services());
    self->listen();
  });
}

void Viewer::close(const std::string& why) {
  if (!open_ || ended_ || closing_) return;
  closing_ = true;
  socket_.async_close({websocket::close_code::policy_error, why},
                      [self = shared_from_this()](beast::error_code) { self->end(); });
}

void Viewer::end() {
  if (std::exchange(ended_, true)) return;
  open_ = false;
  beast::get_lowest_layer(socket_).close();
  host_.gone(*this);
}

void Viewer::listen() {
  socket_.async_read(heard_, [self = shared_from_this()](beast::error_code fault, std::size_t) {
    if (fault) return self->end();
    try {
      self->hear();
    } catch (const std::exception&) {  // nothing would be heard of it any more
      return self->end();
    }
    self->heard_.consume(self->heard_.size());
    self->listen();
  });
}

void Viewer::hear() {
  const auto data = heard_.cdata();
  const auto* bytes = static_cast<const std::byte*>(data.data());
  const foxglove::Heard heard = socket_.got_text()
                                    ? foxglove::hear_text({reinterpret_cast<const char*>(bytes), data.size()})
                                    : foxglove::hear_binary({bytes, data.size()});
  if (const auto* subscribe = std::get_if<foxglove::Subscribe>(&heard)) {
    for (const auto& one : subscribe->all) {
      if (subscriptions_.size() >= 64 && !subscriptions_.contains(one.subscription)) {
        note("subscribe: 64 subscriptions are enough for any page");
        break;
      }
      const std::uint64_t from = kind(one.channel).latched ? 0 : host_.newest(one.channel);
      subscriptions_[one.subscription] = {one.channel, from};
    }
  } else if (const auto* unsubscribe = std::get_if<foxglove::Unsubscribe>(&heard)) {
    for (const std::uint32_t id : unsubscribe->subscriptions) subscriptions_.erase(id);
  } else if (const auto* call = std::get_if<foxglove::Call>(&heard)) {
    host_.call(*this, *call);
  } else if (const auto* bad_call = std::get_if<foxglove::BadCall>(&heard)) {
    if (bears()) say(foxglove::call_failure(bad_call->service, bad_call->id, bad_call->fault));
  } else if (const auto* passed = std::get_if<foxglove::PassedOver>(&heard)) {
    if (!passed->note.empty() && bears()) say(foxglove::status(foxglove::Level::kWarning, passed->note));
  } else {
    note(std::get<foxglove::Bad>(heard).fault);
  }
}

/// One more that cannot be understood: false when it was one too many.
bool Viewer::bears() {
  if (++notes_ <= kMostNotes) return true;
  close("too much that cannot be understood");
  return false;
}

void Viewer::note(const std::string& fault) {
  if (bears()) say(foxglove::status(foxglove::Level::kError, fault));
}

void Viewer::say(std::string text) { queue(bytes_of(text), true); }

void Viewer::respond(const foxglove::Call& call, const std::string& json) {
  queue(foxglove::call_response(call.service, call.id, json), false);
}

void Viewer::queue(std::vector<std::byte> bytes, bool text) {
  if (ended_ || closing_) return;
  waiting_bytes_ += bytes.size();
  waiting_.push_back({std::move(bytes), text});
  if (waiting_bytes_ > kMostWaiting) {  // it does not read: closing politely would wait for it too
    waiting_.clear();
    return end();
  }
  if (!writing_) write_queued();
}

void Viewer::write_queued() {
  if (waiting_.empty() || !open_ || closing_) return;
  writing_ = true;
  socket_.text(waiting_.front().text);
  const auto& bytes = waiting_.front().bytes;
  socket_.async_write(boost::asio::buffer(bytes.data(), bytes.size()),
                      [self = shared_from_this()](beast::error_code fault, std::size_t size) {
                        if (!fault && !self->waiting_.empty()) {
                          self->waiting_bytes_ -= std::min(self->waiting_bytes_, size);
                          self->waiting_.pop_front();
                        }
                        self->written(fault);
                      });
}

void Viewer::written(beast::error_code fault) {
  writing_ = false;
  if (fault) return end();
  write_queued();
}

void Viewer::want(Wanted& wanted) const {
  for (const auto& [id, subscription] : subscriptions_)
    wanted[static_cast<std::size_t>(subscription.channel)] = true;
}

std::uint64_t Viewer::missed(const Source& source) const {
  std::uint64_t missed = dropped_;
  for (const auto& [id, subscription] : subscriptions_) {
    if (subscription.channel == Channel::kVoxels || subscription.last == 0) continue;
    const std::uint64_t newest = source.newest(subscription.channel).number;
    if (newest > subscription.last) missed += newest - subscription.last - 1;
  }
  return missed;
}

void Viewer::send_news(Source& source) {
  if (writing_ || !open_ || closing_) return;
  write_newest(source);
}

/// One message: of the first subscription, from the one behind that served last on, that has news.
bool Viewer::write_newest(Source& source) {
  auto at = subscriptions_.upper_bound(served_last_);
  for (std::size_t i = 0; i < subscriptions_.size(); ++i, ++at) {
    if (at == subscriptions_.end()) at = subscriptions_.begin();
    auto& [id, subscription] = *at;
    Time stamp{};
    if (subscription.channel == Channel::kVoxels) {
      body_ = source.voxels(subscription.last);
    } else {
      const Newest newest = source.newest(subscription.channel);
      if (newest.number <= subscription.last) continue;
      if (subscription.last > 0) dropped_ += newest.number - subscription.last - 1;
      subscription.last = newest.number;
      stamp = newest.time;
      body_ = newest.cdr;
    }
    if (!body_) continue;
    served_last_ = id;
    head_ = foxglove::message_head(id, stamp);
    writing_ = true;
    socket_.binary(true);
    const std::array<boost::asio::const_buffer, 2> both{boost::asio::buffer(head_),
                                                        boost::asio::buffer(body_->data(), body_->size())};
    socket_.async_write(both, [self = shared_from_this(), &source](beast::error_code fault, std::size_t) {
      ++self->sent_;
      self->body_.reset();
      self->written(fault);
      if (!fault) self->send_news(source);
    });
    return true;
  }
  return false;
}

}  // namespace headway::remote
