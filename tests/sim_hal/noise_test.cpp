#include "sim_hal/noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "sim_hal/noise_field.h"
#include "sim_hal/texture.h"

namespace headway::sim {
namespace {

TEST(Texture, ChangesSlowlyAndHasNoDetailFinerThanAPixel) {
  const TextureSampler sampler({.name = "t", .grain = 0.01, .octaves = 6}, 4);
  for (const float footprint : {0.001F, 0.01F, 0.05F}) {
    // Steps of a tenth of the finest detail that may be left: of a grain, or of two pixels.
    const float step = 0.1F * std::max(0.01F, footprint);
    float largest = 0, lowest = 1, highest = 0;
    for (int i = 0; i < 5000; ++i) {
      const float x = step * static_cast<float>(i);
      const float here = sampler.reflectance({x, 0.3F, 0.1F}, footprint);
      largest = std::max(largest, std::abs(sampler.reflectance({x + step, 0.3F, 0.1F}, footprint) - here));
      lowest = std::min(lowest, here), highest = std::max(highest, here);
    }
    EXPECT_LT(largest, 0.15F) << footprint;
    EXPECT_GT(highest - lowest, footprint < 0.02F ? 0.3F : 0.1F) << footprint;
  }
}

TEST(Texture, HasTheAskedBrightnessAndContrast) {
  const Texture texture{.name = "t", .brightness = 0.5, .contrast = 0.4, .grain = 0.01, .octaves = 5};
  double sum = 0, squares = 0;
  int n = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const TextureSampler sampler(texture, seed);
    for (int i = 0; i < 5000; ++i, ++n) {
      const auto at = [&](std::uint64_t axis) {
        return static_cast<float>(uniform(noise_key(seed, axis), static_cast<std::uint64_t>(i))) * 4 - 2;
      };
      const double v = static_cast<double>(sampler.reflectance({at(0), at(1), at(2)}, 0.001F));
      sum += v, squares += v * v;
    }
  }
  const double mean = sum / n;
  EXPECT_NEAR(mean, 0.5, 0.01);
  EXPECT_NEAR(2 * std::sqrt(squares / n - mean * mean) / mean, 0.4, 0.03);
}

TEST(NoiseField, HasUnitVarianceAndFallsToOneEthAtItsCorrelationLength) {
  constexpr int kSize = 300;
  for (const double length : {0.0, 2.0, 5.0}) {
    const std::vector<float> field = noise_field(kSize, kSize, length, 3);
    double sum = 0, squares = 0, product = 0;
    const int lag = std::max(1, static_cast<int>(length));
    int n = 0;
    for (int v = 0; v < kSize; ++v)
      for (int u = 0; u + lag < kSize; ++u, ++n) {
        const double a = static_cast<double>(field[static_cast<std::size_t>(v * kSize + u)]);
        sum += a, squares += a * a,
            product += a * static_cast<double>(field[static_cast<std::size_t>(v * kSize + u + lag)]);
      }
    EXPECT_NEAR(sum / n, 0, 0.05);
    EXPECT_NEAR(squares / n, 1, 0.06) << length;
    EXPECT_NEAR(product / squares, length > 0 ? std::exp(-1) : 0, 0.05) << length;
  }
}

TEST(Noise, IsNormal) {
  // Against the standard normal's distribution function (Kolmogorov-Smirnov).
  constexpr int kCount = 100000;
  std::vector<double> values;
  for (std::uint64_t i = 0; i < kCount; ++i) values.push_back(static_cast<double>(normal(42, i)));
  std::sort(values.begin(), values.end());
  double worst = 0;
  for (int i = 0; i < kCount; ++i) {
    const double expected = 0.5 * std::erfc(-values[static_cast<std::size_t>(i)] / std::numbers::sqrt2);
    worst = std::max(worst, std::abs(expected - (i + 0.5) / kCount));
  }
  EXPECT_LT(worst, 0.006);
}

}  // namespace
}  // namespace headway::sim
