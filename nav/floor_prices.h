// What each cell adds to the walking time: the nearness of obstacles, and floor that nobody has seen.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/gait.h"
#include "nav/ground.h"
#include "nav/planner.h"

namespace headway::nav {

/// Seconds to whole milliseconds, the planner's unit.
std::uint32_t milliseconds(double s);

class FloorPrices {
 public:
  FloorPrices(const PlannerConfig& config, const GaitLimits& gait, double resolution);

  /// From the ground of all cells, row-major width x height.
  void compute(int width, int height, const std::vector<Ground>& ground);

  /// Added to a motion [ms] that reaches the cell straight or diagonally.
  std::uint32_t total(std::size_t cell, bool diagonal) const { return total_[cell][diagonal ? 1 : 0]; }
  std::uint32_t near(std::size_t cell, bool diagonal) const { return near_price(distance2_[cell], diagonal); }
  std::uint32_t unseen(std::size_t cell, bool diagonal) const {
    return unseen_price(unseen_[cell], diagonal);
  }

 private:
  using Prices = std::array<std::uint32_t, 2>;

  std::uint32_t near_price(std::uint16_t distance2, bool diagonal) const {
    return near_prices_[distance2][diagonal ? 1 : 0];
  }
  std::uint32_t unseen_price(std::uint16_t count, bool diagonal) const {
    return unseen_prices_[count][diagonal ? 1 : 0];
  }
  void measure_distances(int width, int height, const std::vector<Ground>& ground);
  void count_unseen(int width, int height, const std::vector<Ground>& ground);

  int range_, corridor_;                             ///< [cells]
  std::vector<Prices> near_prices_, unseen_prices_;  ///< by squared distance [cells^2], by cells unseen
  std::vector<std::uint16_t> distance2_, unseen_, row_;
  std::vector<Prices> total_;
};

}  // namespace headway::nav
