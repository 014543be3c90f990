// CRC-32 as in Ethernet, zip and PNG (polynomial 0x04C11DB7, reflected): tells a damaged file from a whole
// one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace headway::nav {

class Checksum {
 public:
  void add(std::string_view bytes) {
    for (const char c : bytes) state_ = state_ >> 8 ^ kTable[(state_ ^ static_cast<std::uint8_t>(c)) & 255];
  }
  /// Of all bytes so far.
  std::uint32_t value() const { return ~state_; }

 private:
  static constexpr auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t rest = i;
      for (int bit = 0; bit < 8; ++bit) rest = rest >> 1 ^ ((rest & 1) != 0 ? 0xEDB88320U : 0U);
      table[i] = rest;
    }
    return table;
  }();
  std::uint32_t state_ = ~0U;
};

}  // namespace headway::nav
