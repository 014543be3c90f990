// Numbers of walks and of their steps. Sessions count 1, 2, ... 15 and then from 1 again, 0 is none. Steps
// count 0, 1, 2, ... within a session; the wire carries them modulo 64, and 255 for none.
#pragma once

#include <cstdint>
#include <optional>

namespace headway::hal {

inline constexpr std::uint8_t kLastSession = 15;
inline constexpr std::uint32_t kStepNumbers = 64;

constexpr std::uint8_t wire_number(std::uint32_t index) noexcept {
  return static_cast<std::uint8_t>(index % kStepNumbers);
}

/// The newest index not after `newest` (the last one sent) that travels as `number`; nothing for kNoStep,
/// other numbers that cannot be, and numbers before the first step. Right as long as it lies less than 64
/// back.
constexpr std::optional<std::uint32_t> unwrapped(std::uint8_t number, std::uint32_t newest) noexcept {
  if (number >= kStepNumbers) return std::nullopt;
  const std::uint32_t back = (newest % kStepNumbers + kStepNumbers - number) % kStepNumbers;
  if (back > newest) return std::nullopt;
  return newest - back;
}

}  // namespace headway::hal
