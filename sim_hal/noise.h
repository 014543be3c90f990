// Noise without a state: a number for each (key, counter), whatever the order or the thread in which it is
// asked.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace headway::sim {

/// Mixes 64 bits so that each depends on all (the finaliser of SplitMix64).
constexpr std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

constexpr std::uint64_t noise_key(std::uint64_t a, std::uint64_t b, std::uint64_t c = 0) {
  return mixed(mixed(mixed(a) ^ b) ^ c);
}

/// In [0, 1).
constexpr double uniform(std::uint64_t key, std::uint64_t counter) {
  return static_cast<double>(mixed(key + counter * 0xd1342543de82ef95ULL) >> 11) * 0x1p-53;
}

/// Standard normal (Irwin-Hall of six 10-bit numbers: cheap, exact on every machine, no value beyond 4.2).
constexpr float normal(std::uint64_t key, std::uint64_t counter) {
  const std::uint64_t bits = mixed(key + counter * 0xd1342543de82ef95ULL);
  int sum = 0;
  for (int i = 0; i < 6; ++i) sum += static_cast<int>((bits >> (10 * i)) & 1023U);
  // Mean 6 * 511.5, variance 6 (1024^2 - 1) / 12.
  return (static_cast<float>(sum) - 3069.0F) * (1.0F / 724.07706F);
}

}  // namespace headway::sim
