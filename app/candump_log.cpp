#include "app/candump_log.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "config/yaml_limits.h"
#include "hal/error.h"

namespace headway::app {

namespace {

using Kind = LoggedFrame::Kind;

constexpr std::uint32_t kErrorFlag = CandumpLog::kErrorFlag, kHighestExtended = 0x1FFFFFFF,
                        kHighestId = 0x7FF;

/// The whole text as a number without a sign.
template <class Number>
std::optional<Number> number_of(std::string_view text, int base) {
  Number value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  const bool whole =
      fault == std::errc() && end == text.data() + text.size() && !text.empty() && text[0] != '-';
  return whole ? std::optional(value) : std::nullopt;
}

/// Seconds with up to nine decimals, to the nanosecond: a double would not hold them.
std::optional<Duration> stamp_of(std::string_view text) {
  if (text.size() < 2 || text.front() != '(' || text.back() != ')') return std::nullopt;
  text = text.substr(1, text.size() - 2);
  const std::size_t dot = std::min(text.find('.'), text.size());
  std::string decimals(text.substr(std::min(dot + 1, text.size())));
  if (decimals.size() > 9) return std::nullopt;
  decimals.resize(9, '0');
  const auto whole = number_of<std::int64_t>(text.substr(0, dot), 10);
  const auto part = number_of<std::int64_t>(decimals, 10);
  if (!whole || !part || *whole > 9'000'000'000) return std::nullopt;
  return std::chrono::seconds(*whole) + Duration(*part);
}

/// 3 digits are 11 bits; 8 digits are 29 bits, or an error frame.
bool read_id(std::string_view text, LoggedFrame& into) {
  const auto id = number_of<std::uint32_t>(text, 16);
  if (!id || (text.size() != 3 && text.size() != 8)) return false;
  if (text.size() == 3) {
    into.frame.id = *id;
    return *id <= kHighestId;
  }
  into.kind = (*id & kErrorFlag) != 0 ? Kind::kError : Kind::kExtended;
  into.frame.id = *id & kHighestExtended;
  return (*id & ~(kErrorFlag | kHighestExtended)) == 0;
}

bool read_data(std::string_view text, hal::CanFrame& into) {
  if (text.size() % 2 != 0 || text.size() > 16) return false;
  into.dlc = static_cast<std::uint8_t>(text.size() / 2);
  for (std::size_t i = 0; i < into.dlc; ++i) {
    const auto byte = number_of<std::uint8_t>(text.substr(2 * i, 2), 16);
    if (!byte) return false;
    into.data[i] = *byte;
  }
  return true;
}

/// R, or R and the length that is asked for.
bool read_remote(std::string_view text, LoggedFrame& into) {
  if (into.kind == Kind::kError) return false;
  into.kind = Kind::kRemote;
  const auto length = text.size() == 1 ? 0 : number_of<std::uint8_t>(text.substr(1), 10);
  into.frame.dlc = length.value_or(9);
  return into.frame.dlc <= 8;
}

std::optional<LoggedFrame> read(const std::string& line) {
  LoggedFrame frame;
  std::string stamp, what, direction;
  std::istringstream words(line);
  if (!(words >> stamp >> frame.bus >> what)) return std::nullopt;
  // candump -x adds who sent it.
  if (words >> direction && direction != "R" && direction != "T") return std::nullopt;
  const auto when = stamp_of(stamp);
  const std::size_t mark = what.find('#');
  if (!when || mark == std::string::npos) return std::nullopt;
  frame.stamp = *when;
  if (!read_id(std::string_view(what).substr(0, mark), frame)) return std::nullopt;
  const std::string_view rest = std::string_view(what).substr(mark + 1);
  const bool good = rest.starts_with('R') ? read_remote(rest, frame) : read_data(rest, frame.frame);
  return good ? std::optional(frame) : std::nullopt;
}

}  // namespace

CandumpLog::CandumpLog(const std::filesystem::path& file, std::function<void(const std::string&)> on_bad_line)
    : file_(file), on_bad_line_(std::move(on_bad_line)) {
  errno = 0;
  in_.open(file);
  const int number = std::filesystem::is_directory(file) ? EISDIR : in_ ? 0 : errno;
  if (number != 0)
    throw InputError(fmt::format("{}: cannot be read ({}), expected a log that candump -l wrote",
                                 file.string(), std::strerror(number)));
}

std::optional<LoggedFrame> CandumpLog::next() {
  for (std::string line; std::getline(in_, line);) {
    ++line_;
    if (std::all_of(line.begin(), line.end(), [](unsigned char c) { return std::isspace(c) != 0; })) continue;
    if (auto frame = read(line)) return frame;
    on_bad_line_(fmt::format(
        "{}:{}: '{}' is no classic CAN frame, expected '(seconds) interface id#data' as candump -l writes",
        file_.string(), line_, config::one_line(line, 60)));
  }
  return std::nullopt;
}

}  // namespace headway::app
