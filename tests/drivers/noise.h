// Numbers that look random and are the same on every run of one seed.
#pragma once

#include <cstdint>

namespace headway::drivers::testing {

class Noise {
 public:
  explicit Noise(std::uint32_t seed) : state_(seed) {}
  /// 0 to `end` - 1.
  std::uint32_t below(std::uint32_t end) {
    state_ = state_ * 1664525u + 1013904223u;  // Numerical Recipes' generator
    return (state_ >> 8) % end;
  }
  std::uint32_t percent() { return below(100); }

 private:
  std::uint32_t state_;
};

}  // namespace headway::drivers::testing
