#include "nav/floor_prices.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headway::nav {

std::uint32_t milliseconds(double s) { return static_cast<std::uint32_t>(std::lround(1000 * s)); }

FloorPrices::FloorPrices(const PlannerConfig& config, const GaitLimits& gait, double resolution)
    : range_(static_cast<int>(std::floor(config.near_range / resolution + 1e-9))),
      corridor_(static_cast<int>(std::floor(config.corridor / resolution + 1e-9))) {
  const double straight = gait.forward_seconds(resolution), diagonal = std::numbers::sqrt2 * straight;
  const int beyond = (range_ + 1) * (range_ + 1);
  for (int d2 = 0; d2 <= beyond; ++d2) {
    const double far = std::sqrt(d2) * resolution / std::max(config.near_range, 1e-9);
    const double price = d2 == beyond ? 0 : config.near_price * std::max(0.0, 1 - far);
    near_prices_.push_back({milliseconds(price * straight), milliseconds(price * diagonal)});
  }
  const int square = (2 * corridor_ + 1) * (2 * corridor_ + 1);
  for (int count = 0; count <= square; ++count) {
    const double price = config.unseen_price * count / square;
    unseen_prices_.push_back({milliseconds(price * straight), milliseconds(price * diagonal)});
  }
}

void FloorPrices::compute(int width, int height, const std::vector<Ground>& ground) {
  measure_distances(width, height, ground);
  count_unseen(width, height, ground);
  total_.resize(ground.size());
  for (std::size_t i = 0; i < ground.size(); ++i) {
    const Prices& near = near_prices_[distance2_[i]];
    const Prices& unseen = unseen_prices_[unseen_[i]];
    total_[i] = {near[0] + unseen[0], near[1] + unseen[1]};
  }
}

void FloorPrices::measure_distances(int width, int height, const std::vector<Ground>& ground) {
  const int beyond = (range_ + 1) * (range_ + 1);
  const auto w = static_cast<std::size_t>(width);
  // Squared distance to the nearest blocked cell of the same row first, then the best over the rows within
  // range.
  row_.resize(ground.size());
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
    const auto sweep = [&](int from, int to, int step) {
      int since = range_ + 1;
      for (int x = from; x != to; x += step) {
        const std::size_t i = y * w + static_cast<std::size_t>(x);
        since = is_obstacle(ground[i]) ? 0 : std::min(since + 1, range_ + 1);
        const auto squared = static_cast<std::uint16_t>(since * since);
        row_[i] = step > 0 ? squared : std::min(row_[i], squared);
      }
    };
    sweep(0, width, 1);
    sweep(width - 1, -1, -1);
  }
  distance2_.assign(ground.size(), static_cast<std::uint16_t>(beyond));
  for (int y = 0; y < height; ++y) {
    std::uint16_t* best = distance2_.data() + static_cast<std::size_t>(y) * w;
    for (int other = std::max(0, y - range_); other <= std::min(height - 1, y + range_); ++other) {
      const std::uint16_t* row = row_.data() + static_cast<std::size_t>(other) * w;
      const auto rise = static_cast<std::uint16_t>((other - y) * (other - y));
      for (std::size_t x = 0; x < w; ++x)
        best[x] = std::min(best[x], static_cast<std::uint16_t>(row[x] + rise));
    }
  }
}

void FloorPrices::count_unseen(int width, int height, const std::vector<Ground>& ground) {
  const auto w = static_cast<std::size_t>(width);
  // Cells unseen in the corridor's stretch of the row, then summed over the rows of its square.
  for (int y = 0; y < height; ++y) {
    const std::size_t begin = static_cast<std::size_t>(y) * w;
    int count = 0;
    const auto unseen = [&](int x) { return ground[begin + static_cast<std::size_t>(x)] == Ground::kUnseen; };
    for (int x = 0; x < std::min(corridor_, width); ++x) count += unseen(x);
    for (int x = 0; x < width; ++x) {
      if (x + corridor_ < width) count += unseen(x + corridor_);
      if (x - corridor_ - 1 >= 0) count -= unseen(x - corridor_ - 1);
      row_[begin + static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(count);
    }
  }
  unseen_.assign(ground.size(), 0);
  for (int y = 0; y < height; ++y) {
    std::uint16_t* sum = unseen_.data() + static_cast<std::size_t>(y) * w;
    for (int other = std::max(0, y - corridor_); other <= std::min(height - 1, y + corridor_); ++other) {
      const std::uint16_t* row = row_.data() + static_cast<std::size_t>(other) * w;
      for (std::size_t x = 0; x < w; ++x) sum[x] = static_cast<std::uint16_t>(sum[x] + row[x]);
    }
  }
}

}  // namespace headway::nav
