// How signals lie in a CAN frame: bit fields of the eight data bytes read as one little-endian word.
#pragma once

#include <cstdint>
#include <limits>

#include "hal/can_bus.h"

namespace headway::hal::bus {

/// One signal: its bits and the raw values that the contract declares.
struct Field {
  unsigned start = 0, length = 0;  ///< lowest bit, number of bits (below 64)
  bool is_signed = false;
  std::int64_t lowest = 0, highest = 0;  ///< raw
};

constexpr std::uint64_t word_of(const CanFrame& frame) noexcept {
  std::uint64_t word = 0;
  for (unsigned i = 0; i < 8; ++i) word |= std::uint64_t{frame.data[i]} << (8 * i);
  return word;
}

constexpr CanFrame frame_of(std::uint32_t id, std::uint8_t dlc, std::uint64_t word) noexcept {
  CanFrame frame{.id = id, .dlc = dlc};
  for (unsigned i = 0; i < 8; ++i) frame.data[i] = static_cast<std::uint8_t>(word >> (8 * i));
  return frame;
}

constexpr bool is_declared(const Field& f, std::int64_t raw) noexcept {
  return raw >= f.lowest && raw <= f.highest;
}

/// Writes a raw value; false, and nothing written, when it is not declared.
constexpr bool put(std::uint64_t& word, const Field& f, std::int64_t raw) noexcept {
  if (!is_declared(f, raw)) return false;
  const std::uint64_t mask = ((std::uint64_t{1} << f.length) - 1) << f.start;
  word = (word & ~mask) | ((static_cast<std::uint64_t>(raw) << f.start) & mask);
  return true;
}

/// Writes the nearest raw value (halves away from zero); false when it is not declared, or not a number.
constexpr bool put_scaled(std::uint64_t& word, const Field& f, double scale, double offset,
                          double physical) noexcept {
  const double raw = (physical - offset) / scale;
  const double rounded = raw < 0 ? raw - 0.5 : raw + 0.5;
  // In doubles first: the cast below is undefined beyond the integers, and false for what is not a number.
  if (!(rounded > static_cast<double>(f.lowest) - 1 && rounded < static_cast<double>(f.highest) + 1)) {
    return false;
  }
  return put(word, f, static_cast<std::int64_t>(rounded));
}

/// Reads a raw value; false when it is not declared.
constexpr bool get(std::uint64_t word, const Field& f, std::int64_t& raw) noexcept {
  const std::uint64_t bits = (word >> f.start) & ((std::uint64_t{1} << f.length) - 1);
  const bool negative = f.is_signed && ((bits >> (f.length - 1)) & 1) != 0;
  raw = static_cast<std::int64_t>(bits) - (negative ? std::int64_t{1} << f.length : std::int64_t{0});
  return is_declared(f, raw);
}

/// Reads a value into a member of integer or enumeration type.
template <class T>
constexpr bool get_as(std::uint64_t word, const Field& f, T& into) noexcept {
  std::int64_t raw = 0;
  if (!get(word, f, raw)) return false;
  into = static_cast<T>(raw);
  return true;
}

/// Reads a value in physical units.
constexpr bool get_scaled(std::uint64_t word, const Field& f, double scale, double offset,
                          double& into) noexcept {
  std::int64_t raw = 0;
  if (!get(word, f, raw)) return false;
  into = static_cast<double>(raw) * scale + offset;
  return true;
}

/// For tools that hold every value as a double: into a member of integer or enumeration type, when it fits.
template <class T, class Number = T>
constexpr bool from_double(double value, T& into) noexcept {
  if (!(value >= static_cast<double>(std::numeric_limits<Number>::lowest()) &&
        value <= static_cast<double>(std::numeric_limits<Number>::max()))) {
    return false;
  }
  into = static_cast<T>(static_cast<Number>(value));
  return static_cast<double>(static_cast<Number>(value)) == value;
}

}  // namespace headway::hal::bus
