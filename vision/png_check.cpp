#include "vision/png_check.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

namespace headway::vision {

namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::size_t kFrame = 12;  // length, type and checksum of a chunk

std::uint32_t number(Bytes b, std::size_t at) {
  return std::uint32_t{b[at]} << 24 | std::uint32_t{b[at + 1]} << 16 | std::uint32_t{b[at + 2]} << 8 |
         b[at + 3];
}

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = (c & 1) ? 0xEDB88320U ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  return table;
}

// CRC-32 of type and data (PNG specification, annex D).
std::uint32_t crc(Bytes b) {
  static constexpr auto kTable = crc_table();
  std::uint32_t c = 0xFFFFFFFFU;
  for (const std::uint8_t byte : b) c = kTable[(c ^ byte) & 0xFF] ^ (c >> 8);
  return ~c;
}

}  // namespace

bool is_png(Bytes bytes) {
  return bytes.size() >= kSignature.size() && std::equal(kSignature.begin(), kSignature.end(), bytes.begin());
}

std::string png_fault(Bytes bytes, double largest_megapixels) {
  std::size_t at = kSignature.size();
  bool first = true;
  while (at + kFrame <= bytes.size()) {
    const std::size_t length = number(bytes, at);
    if (length > bytes.size() - at - kFrame) return "is truncated";
    const std::string_view type(reinterpret_cast<const char*>(bytes.data()) + at + 4, 4);
    if (crc(bytes.subspan(at + 4, length + 4)) != number(bytes, at + 8 + length))
      return fmt::format("is damaged (checksum at byte {})", at);
    if (first) {
      if (type != "IHDR" || length != 13) return "is damaged (no header)";
      const double megapixels = 1e-6 * number(bytes, at + 8) * number(bytes, at + 12);
      if (megapixels > largest_megapixels)
        return fmt::format("has {:.0f} megapixels, expected at most {:.0f}", megapixels, largest_megapixels);
      first = false;
    }
    if (type == "IEND") return "";
    at += length + kFrame;
  }
  return "is truncated";
}

}  // namespace headway::vision
