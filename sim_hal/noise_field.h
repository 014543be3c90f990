// An image of standard normal noise, white or with neighbours alike.
#pragma once

#include <cstdint>
#include <vector>

namespace headway::sim {

/// height x width values, row-major, mean 0, variance 1 everywhere. The correlation of two values falls to
/// 1/e at a distance of `correlation` pixels; 0: independent values.
std::vector<float> noise_field(int width, int height, double correlation, std::uint64_t key);

}  // namespace headway::sim
