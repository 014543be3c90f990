// Who a client is: tokens, the cookies they are traded for, and which hosts and origins are ours.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/time.h"

namespace headway::remote {

enum class Role : std::uint8_t { kNone, kViewer, kOperator };
const char* name(Role role);

/// 256 bits from the system's generator, as 64 hexadecimal digits. Throws Error where there are none.
std::string random_token();

struct Tokens {
  std::string operate, view;
};
/// Those of the file; where there is none, new ones, written so that only its owner may read it. Throws
/// InputError where others may read it or it holds no tokens, Error where it cannot be written.
Tokens tokens_in(const std::filesystem::path& file);

class Access {
 public:
  static constexpr int kMostFailures = 5;             ///< until it is said that there were too many
  static constexpr Duration kForgiven = seconds(10);  ///< after so long one more may be tried
  static constexpr std::size_t kMostSessions = 64;    ///< the oldest make room
  static constexpr const char* kCookie = "headway_session";

  /// Without tokens everybody is an operator: for loopback only.
  explicit Access(std::optional<Tokens> tokens) : tokens_(std::move(tokens)) {}

  bool needs_token() const { return tokens_.has_value(); }
  struct Login {
    enum class Outcome : std::uint8_t { kIn, kWrong, kTooOften } outcome;
    std::string cookie;  ///< "headway_session=..."
  };
  /// Trades a token for a session.
  Login log_in(std::string_view token, Time now);
  /// By the request's Cookie header.
  Role role_of(std::string_view cookies) const;

 private:
  std::optional<Tokens> tokens_;
  std::vector<std::pair<std::string, Role>> sessions_;  ///< the oldest first
  int failures_ = 0;
  Time failed_at_{};
};

/// Equal, in a time that does not tell how much of it is.
bool same_secret(std::string_view a, std::string_view b);

/// Whether a Host header names this server: an address of it, localhost, or a name it is known by. What a
/// browser was made to look up under another name (DNS rebinding) is not.
bool is_our_host(std::string_view host, std::string_view bound, const std::vector<std::string>& names);
/// Whether an Origin header is of a page of this very host.
bool is_our_origin(std::string_view origin, std::string_view host);

}  // namespace headway::remote
