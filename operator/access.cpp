#include "operator/access.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::remote {

namespace {

constexpr std::size_t kTokenDigits = 64;

bool is_token(const std::string& text) {
  return text.size() == kTokenDigits && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// Made for its owner alone, from the first moment on.
void write_new(const std::filesystem::path& file, const Tokens& tokens) {
  std::error_code ignored;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  const std::string text = fmt::format("operator {}\nviewer {}\n", tokens.operate, tokens.view);
  const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  const bool whole = out >= 0 && ::write(out, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (out >= 0) ::close(out);
  if (!whole)
    throw Error(fmt::format("{}: cannot be written; --token-file names another place for the page's tokens",
                            file.string()));
}

std::string_view host_name(std::string_view host) {
  if (host.starts_with('[')) return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

}  // namespace

const char* name(Role role) {
  switch (role) {
    case Role::kNone:
      return "none";
    case Role::kViewer:
      return "viewer";
    case Role::kOperator:
      return "operator";
  }
  return "?";
}

std::string random_token() {
  std::array<unsigned char, kTokenDigits / 2> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
    throw Error("the system has no random numbers for the page's tokens");
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

Tokens tokens_in(const std::filesystem::path& file) {
  std::error_code fault;
  if (!std::filesystem::exists(file, fault)) {
    Tokens tokens{random_token(), random_token()};
    write_new(file, tokens);
    return tokens;
  }
  struct stat facts {};
  if (::stat(file.c_str(), &facts) != 0 || (facts.st_mode & 077) != 0)
    throw InputError(
        fmt::format("{}: others than its owner may read the page's tokens; chmod 600, or remove "
                    "it for new ones",
                    file.string()));
  std::ifstream in(file);
  std::string who, token;
  Tokens tokens;
  while (in >> who >> token) (who == "operator" ? tokens.operate : tokens.view) = token;
  if (!is_token(tokens.operate) || !is_token(tokens.view))
    throw InputError(
        fmt::format("{}: expected lines 'operator TOKEN' and 'viewer TOKEN', each of {} "
                    "hexadecimal digits; remove it for new ones",
                    file.string(), kTokenDigits));
  return tokens;
}

bool same_secret(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

Access::Login Access::log_in(std::string_view token, Time now) {
  using Outcome = Login::Outcome;
  if (!tokens_) return {Outcome::kIn, ""};
  if (now - failed_at_ > kForgiven) failures_ = std::max(0, failures_ - 1);
  // Both are compared, whatever the first one says. The right one is let in however many wrong ones others
  // have tried, or anybody could lock everybody out.
  const bool operates = same_secret(token, tokens_->operate), views = same_secret(token, tokens_->view);
  if (!operates && !views) {
    if (failures_ >= kMostFailures) return {Outcome::kTooOften, ""};
    ++failures_;
    failed_at_ = now;
    return {Outcome::kWrong, ""};
  }
  if (sessions_.size() >= kMostSessions) sessions_.erase(sessions_.begin());
  sessions_.emplace_back(random_token(), operates ? Role::kOperator : Role::kViewer);
  return {Outcome::kIn, fmt::format("{}={}", kCookie, sessions_.back().first)};
}

Role Access::role_of(std::string_view cookies) const {
  if (!tokens_) return Role::kOperator;
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    std::string_view one = cookies.substr(0, end);
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
    while (one.starts_with(' ')) one.remove_prefix(1);
    const std::string_view key = kCookie;
    if (!one.starts_with(key) || one.size() <= key.size() || one[key.size()] != '=') continue;
    for (const auto& [session, role] : sessions_)
      if (same_secret(one.substr(key.size() + 1), session)) return role;
  }
  return Role::kNone;
}

bool is_our_host(std::string_view host, std::string_view bound, const std::vector<std::string>& names) {
  const std::string_view is = host_name(host);
  if (is.empty()) return false;
  if (is == "localhost" || is == "127.0.0.1" || is == "[::1]" || is == bound) return true;
  // An address cannot be rebound; a name can.
  const bool v4 = is.find_first_not_of("0123456789.") == std::string_view::npos;
  if ((v4 || is.starts_with('[')) && bound != "127.0.0.1" && bound != "::1") return true;
  return std::ranges::find(names, is) != names.end();
}

bool is_our_origin(std::string_view origin, std::string_view host) {
  for (const std::string_view scheme : {"http://", "https://"})
    if (origin.starts_with(scheme) && origin.substr(scheme.size()) == host) return true;
  return false;
}

}  // namespace headway::remote
