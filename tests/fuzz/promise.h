// What holds whatever the input is: a fuzzer ends where it is broken, and so does a test.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace headway::fuzz {

/// Throws std::logic_error that says which promise is broken.
inline void promise(bool kept, std::string_view which, std::string_view seen = "") {
  if (kept) return;
  throw std::logic_error("broken: " + std::string(which) + (seen.empty() ? "" : ": " + std::string(seen)));
}

/// UTF-8 (RFC 3629) without control characters: it may be shown on a terminal, and is one line.
inline bool is_plain_text(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t at) {
      return static_cast<unsigned char>(at < text.size() ? text[at] : 0);
    };
    const unsigned first = byte(i);
    if (first < 0x20 || first == 0x7F) return false;
    const std::size_t length = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    unsigned code = length == 1 ? first : first & (0xFFU >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
      if ((byte(i + k) & 0xC0U) != 0x80U) return false;
      code = code << 6 | (byte(i + k) & 0x3FU);
    }
    constexpr unsigned kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool is_surrogate = code >= 0xD800 && code < 0xE000;
    if ((first >= 0x80 && first < 0xC2) || first > 0xF4 || code < kLeast[length] || code > 0x10FFFF ||
        is_surrogate || (code >= 0x7F && code < 0xA0))
      return false;
    i += length;
  }
  return true;
}

}  // namespace headway::fuzz
