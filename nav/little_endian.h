// Numbers as files hold them, on any machine: the lowest byte first.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace headway::nav {

/// The `kSize` lowest bytes of a number.
template <std::size_t kSize>
class LittleEndian {
 public:
  explicit constexpr LittleEndian(std::uint64_t value) {
    for (std::size_t i = 0; i < kSize; ++i) bytes_[i] = static_cast<char>(value >> (8 * i) & 255);
  }
  constexpr std::string_view text() const { return {bytes_.data(), kSize}; }

 private:
  std::array<char, kSize> bytes_{};
};

constexpr LittleEndian<4> little_endian(float value) {
  return LittleEndian<4>(std::bit_cast<std::uint32_t>(value));
}
constexpr LittleEndian<8> little_endian(double value) {
  return LittleEndian<8>(std::bit_cast<std::uint64_t>(value));
}

}  // namespace headway::nav
