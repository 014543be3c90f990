// Numbers as the wires carry them: USB's little-endian fields, USB/IP's big-endian ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace headway::hil {

using Bytes = std::vector<std::uint8_t>;
using ByteSpan = std::span<const std::uint8_t>;

/// Appends the lowest `size` bytes of a value, lowest first.
inline void append_le(Bytes& bytes, std::uint32_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// Up to four bytes, lowest first. What lies beyond the end counts as 0.
inline std::uint32_t read_le(ByteSpan bytes, std::size_t offset, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size && offset + i < bytes.size(); ++i) {
    value |= std::uint32_t{bytes[offset + i]} << (8 * i);
  }
  return value;
}

inline void append_be32(Bytes& bytes, std::uint32_t value) {
  for (unsigned i = 4; i-- > 0;) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

inline std::uint32_t read_be32(ByteSpan bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | bytes[offset + i];
  return value;
}

}  // namespace headway::hil
