// A row of random numbers that a key repeats on every machine.
#pragma once

#include <cstdint>

#include "sim_hal/noise.h"

namespace headway::sim {

class Dice {
 public:
  explicit Dice(std::uint64_t key) : key_(key) {}
  double between(double low, double high) { return low + (high - low) * uniform(key_, count_++); }
  int whole(int low, int high) { return low + static_cast<int>(between(0, high - low + 1)); }
  bool chance(double share) { return between(0, 1) < share; }

 private:
  std::uint64_t key_, count_ = 0;
};

}  // namespace headway::sim
