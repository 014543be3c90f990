// The Foxglove WebSocket protocol, version 1 (foxglove/ws-protocol, docs/spec.md): bytes of a client into
// what it asks for, and what it is told into bytes. No sockets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "hal/time.h"
#include "operator/channels.h"

namespace headway::remote::foxglove {

/// Both are the same protocol; newer viewers ask for the second.
inline constexpr std::array<std::string_view, 2> kSubprotocols{"foxglove.websocket.v1", "foxglove.sdk.v1"};

/// What a client may call, and whether it must have control for it.
struct ServiceKind {
  std::string_view name;
  enum class Needs : std::uint8_t { kNothing, kOperator, kControl } needs;
};
inline constexpr std::array<ServiceKind, 18> kServices{{
    {"ping", ServiceKind::Needs::kNothing},
    {"stop", ServiceKind::Needs::kNothing},
    {"play", ServiceKind::Needs::kNothing},
    {"take_control", ServiceKind::Needs::kOperator},
    {"release_control", ServiceKind::Needs::kOperator},
    {"renew", ServiceKind::Needs::kOperator},
    {"plan_preview", ServiceKind::Needs::kControl},
    {"plan_confirm", ServiceKind::Needs::kControl},
    {"pause", ServiceKind::Needs::kControl},
    {"resume", ServiceKind::Needs::kControl},
    {"look", ServiceKind::Needs::kControl},
    {"look_around", ServiceKind::Needs::kControl},
    {"explore_preview", ServiceKind::Needs::kControl},
    {"go_home", ServiceKind::Needs::kControl},
    {"tour", ServiceKind::Needs::kControl},
    {"record", ServiceKind::Needs::kControl},
    {"reset", ServiceKind::Needs::kControl},
    {"forget_plan", ServiceKind::Needs::kControl},
}};

// A client -> us. Channels and services are numbered as in kChannels and kServices.
struct Subscribe {
  struct One {
    std::uint32_t subscription = 0;
    Channel channel{};
  };
  std::vector<One> all;
};
struct Unsubscribe {
  std::vector<std::uint32_t> subscriptions;
};
struct Call {
  std::uint32_t service = 0, id = 0;
  std::string body;  ///< JSON: an object, not deeper than kDeepest
};
/// A call that cannot be done, but can be answered.
struct BadCall {
  std::uint32_t service = 0, id = 0;
  std::string fault;
};
/// Something that is passed over on purpose; `note` is to be told to the client, where it is not empty.
struct PassedOver {
  std::string note;
};
struct Bad {
  std::string fault;
};
using Heard = std::variant<Subscribe, Unsubscribe, Call, BadCall, PassedOver, Bad>;

inline constexpr std::size_t kLongestText = 64 * 1024, kDeepest = 16;

/// Whatever the bytes are, never throws.
Heard hear_text(std::string_view text);
Heard hear_binary(std::span<const std::byte> bytes);

// We -> a client.
/// `viewer`: the client's number, by which it finds itself in the status.
std::string server_info(std::string_view robot, std::string_view session, std::string_view role,
                        std::uint64_t viewer);
std::string advertise_channels();
std::string advertise_services();
enum class Level : std::uint8_t { kInfo = 0, kWarning = 1, kError = 2 };
std::string status(Level level, std::string_view message);
std::string call_failure(std::uint32_t service, std::uint32_t id, std::string_view fault);

/// What stands ahead of a message's bytes.
std::array<std::byte, 13> message_head(std::uint32_t subscription, Time stamp);
std::vector<std::byte> call_response(std::uint32_t service, std::uint32_t id, std::string_view json);

}  // namespace headway::remote::foxglove
