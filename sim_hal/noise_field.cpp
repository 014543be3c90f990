#include "sim_hal/noise_field.h"

#include <cmath>
#include <cstddef>

#include "sim_hal/noise.h"

namespace headway::sim {

namespace {

// White noise through a Gaussian of deviation s correlates as exp(-d^2 / (4 s^2)): 1/e at d = 2 s.
std::vector<float> kernel(double correlation) {
  const double s = correlation / 2;
  const int reach = static_cast<int>(std::ceil(3 * s));
  std::vector<double> weights;
  double squares = 0;
  for (int i = -reach; i <= reach; ++i) {
    weights.push_back(std::exp(-i * i / (2 * s * s)));
    squares += weights.back() * weights.back();
  }
  std::vector<float> unit_variance;
  for (const double w : weights) unit_variance.push_back(static_cast<float>(w / std::sqrt(squares)));
  return unit_variance;
}

// rows x columns in, rows x (columns - taps + 1) out, transposed: twice this is a separable filter.
std::vector<float> filtered_transposed(const std::vector<float>& in, std::size_t rows, std::size_t columns,
                                       const std::vector<float>& taps) {
  const std::size_t out_columns = columns + 1 - taps.size();
  std::vector<float> out(rows * out_columns);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < out_columns; ++c) {
      float sum = 0;
      for (std::size_t t = 0; t < taps.size(); ++t) sum += taps[t] * in[r * columns + c + t];
      out[c * rows + r] = sum;
    }
  return out;
}

}  // namespace

std::vector<float> noise_field(int width, int height, double correlation, std::uint64_t key) {
  const std::vector<float> taps = correlation > 0 ? kernel(correlation) : std::vector<float>{1.0F};
  const std::size_t columns = static_cast<std::size_t>(width) + taps.size() - 1,
                    rows = static_cast<std::size_t>(height) + taps.size() - 1;
  std::vector<float> white(columns * rows);
  for (std::size_t i = 0; i < white.size(); ++i) white[i] = normal(key, i);
  if (taps.size() == 1) return white;
  const std::vector<float> across = filtered_transposed(white, rows, columns, taps);
  return filtered_transposed(across, static_cast<std::size_t>(width), rows, taps);
}

}  // namespace headway::sim
