#include "operator/foxglove.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace headway::remote::foxglove {

namespace {

using Json = nlohmann::json;

constexpr std::uint8_t kMessage = 1, kResponse = 3;    // we say
constexpr std::uint8_t kClientMessage = 1, kCall = 2;  // a client says
constexpr std::size_t kMostSubscriptions = 256;        // in one request

std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// Nothing where it is no JSON, or is deeper than it may be: such text is not taken apart at all.
std::optional<Json> parsed(std::string_view text) {
  bool too_deep = false;
  const Json::parser_callback_t watch = [&](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > static_cast<int>(kDeepest);
    return !too_deep;
  };
  std::size_t depth = 0, deepest = 0;
  for (const char c : text) {  // the parser would go down as deep as it is told to
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if ((c == ']' || c == '}') && depth > 0) --depth;
  }
  if (deepest > kDeepest) return std::nullopt;
  Json json = Json::parse(text, watch, false);
  if (json.is_discarded() || too_deep) return std::nullopt;
  return json;
}

std::optional<std::uint32_t> number(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number_unsigned()) return std::nullopt;
  const auto value = found->get<std::uint64_t>();
  if (value > UINT32_MAX) return std::nullopt;
  return static_cast<std::uint32_t>(value);
}

Heard subscribe(const Json& json) {
  const auto list = json.find("subscriptions");
  if (list == json.end() || !list->is_array() || list->size() > kMostSubscriptions)
    return Bad{fmt::format("subscribe: subscriptions: expected a list of up to {}", kMostSubscriptions)};
  Subscribe all;
  for (const Json& one : *list) {
    if (!one.is_object()) return Bad{"subscribe: subscriptions: expected objects"};
    const auto id = number(one, "id"), channel = number(one, "channelId");
    if (!id || !channel) return Bad{"subscribe: expected id and channelId, each a whole number from 0"};
    if (*channel >= kChannels.size())
      return Bad{
          fmt::format("subscribe: there is no channel {}, expected one of those advertised", *channel)};
    all.all.push_back({*id, static_cast<Channel>(*channel)});
  }
  return all;
}

Heard unsubscribe(const Json& json) {
  const auto list = json.find("subscriptionIds");
  if (list == json.end() || !list->is_array() || list->size() > kMostSubscriptions)
    return Bad{fmt::format("unsubscribe: subscriptionIds: expected a list of up to {}", kMostSubscriptions)};
  Unsubscribe all;
  for (const Json& id : *list) {
    if (!id.is_number_unsigned() || id.get<std::uint64_t>() > UINT32_MAX)
      return Bad{"unsubscribe: expected whole numbers from 0"};
    all.subscriptions.push_back(id.get<std::uint32_t>());
  }
  return all;
}

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void put(std::vector<std::byte>& out, const void* from, std::size_t size) {
  const auto* bytes = static_cast<const std::byte*>(from);
  out.insert(out.end(), bytes, bytes + size);
}

/// Opcode, service, call, length of the encoding's name, that name, payload.
Heard call(std::span<const std::byte> bytes) {
  constexpr std::size_t kHead = 13;
  if (bytes.size() < kHead) return Bad{"a call of a service that is shorter than its head"};
  Call out{word(bytes, 1), word(bytes, 5), {}};
  const auto bad = [&](std::string fault) { return BadCall{out.service, out.id, std::move(fault)}; };
  const std::size_t name_size = word(bytes, 9);
  if (name_size > bytes.size() - kHead) return Bad{"a call whose encoding is longer than the whole"};
  if (out.service >= kServices.size()) return bad("there is no such service");
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  if (std::string_view(text + kHead, name_size) != "json") return bad("its encoding: expected json");
  const std::string_view body(text + kHead + name_size, bytes.size() - kHead - name_size);
  if (body.size() > kLongestText) return bad(fmt::format("longer than {} bytes", kLongestText));
  const auto json = parsed(body.empty() ? "{}" : body);
  if (!json || !json->is_object())
    return bad(fmt::format("expected a JSON object, not deeper than {}", kDeepest));
  out.body = dumped(*json);
  return out;
}

}  // namespace

Heard hear_text(std::string_view text) {
  if (text.size() > kLongestText) return Bad{fmt::format("a request longer than {} bytes", kLongestText)};
  const auto json = parsed(text);
  if (!json || !json->is_object())
    return Bad{fmt::format("expected a JSON object with op, not deeper than {}", kDeepest)};
  const auto op = json->find("op");
  if (op == json->end() || !op->is_string()) return Bad{"op: is missing, expected a text such as subscribe"};
  const auto name = op->get<std::string>();
  if (name == "subscribe") return subscribe(*json);
  if (name == "unsubscribe") return unsubscribe(*json);
  if (name == "advertise")
    return PassedOver{"what you publish is not acted upon: a goal is given by plan_preview"};
  if (name == "unadvertise") return PassedOver{};
  return Bad{
      fmt::format("op: '{}' is not offered here, expected subscribe or unsubscribe", name.substr(0, 40))};
}

Heard hear_binary(std::span<const std::byte> bytes) {
  if (bytes.empty()) return Bad{"an empty message"};
  switch (std::to_integer<std::uint8_t>(bytes[0])) {
    case kClientMessage:
      return PassedOver{"what you publish is not acted upon: a goal is given by plan_preview"};
    case kCall:
      return call(bytes);
    default:
      return Bad{"a binary message of unknown kind, expected the call of a service"};
  }
}

std::string server_info(std::string_view robot, std::string_view session, std::string_view role,
                        std::uint64_t viewer) {
  return dumped({{"op", "serverInfo"},
                 {"name", fmt::format("Headway: {}", robot)},
                 {"capabilities", {"services", "clientPublish"}},
                 {"supportedEncodings", {"json", "cdr"}},
                 {"metadata", Json{{"role", role}, {"viewer", std::to_string(viewer)}}},
                 {"sessionId", session}});
}

std::string advertise_channels() {
  Json list = Json::array();
  for (std::size_t i = 0; i < kChannels.size(); ++i)
    list.push_back({{"id", i},
                    {"topic", kChannels[i].topic},
                    {"encoding", "cdr"},
                    {"schemaName", kChannels[i].schema},
                    {"schemaEncoding", "ros2msg"},
                    {"schema", kChannels[i].text()}});
  return dumped({{"op", "advertise"}, {"channels", list}});
}

std::string advertise_services() {
  Json list = Json::array();
  for (std::size_t i = 0; i < kServices.size(); ++i)
    list.push_back({{"id", i},
                    {"name", kServices[i].name},
                    {"type", fmt::format("headway/{}", kServices[i].name)},
                    {"requestSchema", ""},
                    {"responseSchema", ""}});
  return dumped({{"op", "advertiseServices"}, {"services", list}});
}

std::string status(Level level, std::string_view message) {
  return dumped({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}});
}

std::string call_failure(std::uint32_t service, std::uint32_t id, std::string_view fault) {
  return dumped({{"op", "serviceCallFailure"}, {"serviceId", service}, {"callId", id}, {"message", fault}});
}

std::array<std::byte, 13> message_head(std::uint32_t subscription, Time stamp) {
  std::array<std::byte, 13> head{};
  head[0] = std::byte{kMessage};
  const auto ns = static_cast<std::uint64_t>(stamp.time_since_epoch().count());
  std::memcpy(head.data() + 1, &subscription, sizeof subscription);
  std::memcpy(head.data() + 5, &ns, sizeof ns);
  return head;
}

std::vector<std::byte> call_response(std::uint32_t service, std::uint32_t id, std::string_view json) {
  constexpr std::string_view kEncoding = "json";
  const auto size = static_cast<std::uint32_t>(kEncoding.size());
  std::vector<std::byte> out{std::byte{kResponse}};
  put(out, &service, sizeof service);
  put(out, &id, sizeof id);
  put(out, &size, sizeof size);
  put(out, kEncoding.data(), kEncoding.size());
  put(out, json.data(), json.size());
  return out;
}

}  // namespace headway::remote::foxglove
