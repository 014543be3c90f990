#include "drivers/slcan_protocol.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace headway::drivers {

namespace {

constexpr char kEnd = '\r', kBell = '\a';
constexpr std::uint32_t kHighestId = 0x7FF;
constexpr std::size_t kIdDigits = 3;
constexpr std::size_t kStampDigits = 4;  ///< of those adapters that send a time stamp

constexpr char hex_digit(unsigned value) noexcept { return "0123456789ABCDEF"[value & 0xF]; }

/// Hexadecimal, all of it; nothing where it is none.
std::optional<std::uint32_t> number_of(std::string_view digits) noexcept {
  std::uint32_t value = 0;
  for (const char c : digits) {
    const bool decimal = c >= '0' && c <= '9', upper = c >= 'A' && c <= 'F', lower = c >= 'a' && c <= 'f';
    if (!decimal && !upper && !lower) return std::nullopt;
    value = value << 4 | static_cast<std::uint32_t>(decimal ? c - '0' : upper ? c - 'A' + 10 : c - 'a' + 10);
  }
  return value;
}

}  // namespace

SlcanLine::SlcanLine(const hal::CanFrame& frame) noexcept {
  const auto put = [this](char c) { text_[size_++] = c; };
  put('t');
  for (int shift = 8; shift >= 0; shift -= 4) put(hex_digit(frame.id >> shift));
  put(hex_digit(frame.dlc));
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.dlc, 8); ++i) {
    put(hex_digit(frame.data[i] >> 4));
    put(hex_digit(frame.data[i]));
  }
  put(kEnd);
}

SlcanReader::Event SlcanReader::feed(char byte) noexcept {
  if (byte == kBell) {
    size_ = 0;
    return Event::kRefused;
  }
  if (byte != kEnd) {
    if (size_ < line_.size()) line_[size_] = byte;
    size_ = std::min(size_ + 1, line_.size() + 1);
    return Event::kNone;
  }
  const std::size_t size = std::exchange(size_, 0);
  return size > line_.size() ? Event::kUnusable : end_of({line_.data(), size});
}

SlcanReader::Event SlcanReader::end_of(std::string_view line) noexcept {
  // Some answer a frame they were given with z or Z.
  if (line.empty() || line == "z" || line == "Z") return Event::kDone;
  return line.front() == 't' && read_frame(line) ? Event::kFrame : Event::kUnusable;
}

bool SlcanReader::read_frame(std::string_view line) noexcept {
  constexpr std::size_t kData = 1 + kIdDigits + 1;
  if (line.size() < kData) return false;
  const auto id = number_of(line.substr(1, kIdDigits));
  const auto dlc = number_of(line.substr(1 + kIdDigits, 1));
  if (!id || *id > kHighestId || !dlc || *dlc > 8) return false;
  const std::size_t end = kData + std::size_t{2} * *dlc;
  if (line.size() != end && line.size() != end + kStampDigits) return false;
  if (!number_of(line.substr(end))) return false;
  hal::CanFrame frame{.id = *id, .dlc = static_cast<std::uint8_t>(*dlc)};
  for (std::size_t i = 0; i < *dlc; ++i) {
    const auto byte = number_of(line.substr(kData + 2 * i, 2));
    if (!byte) return false;
    frame.data[i] = static_cast<std::uint8_t>(*byte);
  }
  frame_ = frame;
  return true;
}

}  // namespace headway::drivers
