#include "operator/control.h"

#include <cstddef>
#include <optional>

namespace headway::remote {

using Json = nlohmann::json;

std::string refusal(const std::string& why) {
  return Json{{"ok", false}, {"error", why}}.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string name_in(const Json& body, std::uint64_t client) {
  constexpr std::size_t kLongest = 40;
  const auto found = body.find("name");
  std::string name = found != body.end() && found->is_string() ? found->get<std::string>() : "";
  if (name.empty()) return "operator " + std::to_string(client);
  if (name.size() <= kLongest) return name;
  std::size_t end = kLongest;  // no part of a UTF-8 character
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) --end;
  return name.substr(0, end);
}

void Control::look(std::uint32_t status_number) {
  const Time now = clock_.now();
  if (statuses_.empty() || statuses_.back().first != status_number)
    statuses_.emplace_back(status_number, now);
  while (statuses_.size() > 1 && now - statuses_.front().second > 2 * Lease::kFreshState)
    statuses_.pop_front();
  expire();
}

std::string Control::refuse() const {
  return refusal(lease_.holder().client == 0 ? "take control first" : lease_.holder().name + " has control");
}

std::string Control::take(std::uint64_t client, const std::string& name) {
  expire();
  const bool had = lease_.holds(client);
  const auto number = lease_.take(client, name, clock_.now());
  if (!number) return refusal(lease_.holder().name + " has control");
  if (!had) tell();
  return Json{{"ok", true}, {"lease", *number}}.dump();
}

std::string Control::renew(std::uint64_t client, const Json& body) {
  const auto number = [&](const char* key) -> std::optional<std::uint32_t> {
    const auto found = body.find(key);
    if (found == body.end() || !found->is_number_unsigned()) return std::nullopt;
    const auto value = found->get<std::uint64_t>();
    return value <= 0xFFFFFFFFU ? std::optional(static_cast<std::uint32_t>(value)) : std::nullopt;
  };
  const auto lease = number("lease"), state = number("state");
  if (!lease || !state) return refusal("expected lease and state, each a whole number below 2^32");
  expire();
  if (!lease_.holds(client)) return refusal("you do not have control");
  if (statuses_.empty() || *state > statuses_.back().first)
    return refusal("state: there was no such status yet");
  Time seen = clock_.now() - 2 * Lease::kFreshState;
  for (const auto& [status, since] : statuses_)
    if (status <= *state) seen = since;
  if (!lease_.renew(client, *lease, seen, clock_.now()))
    return refusal(*lease == lease_.holder().number ? "what you see is too old"
                                                    : "lease: is an earlier one's; take control again");
  tell();
  return Json{{"ok", true}}.dump();
}

std::string Control::release(std::uint64_t client) {
  if (!lease_.release(client)) return refusal("you do not have control");
  ++released_;
  tell();
  return Json{{"ok", true}}.dump();
}

void Control::expire() {
  if (!lease_.expire(clock_.now())) return;
  ++released_;
  tell();
}

void Control::tell() {
  holder_.publish(lease_.holder());
  word_.publish({lease_.holder().number, released_, clock_.now()});
}

}  // namespace headway::remote
