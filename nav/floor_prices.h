// What each cell adds to the walking time: the nearness of obstacles, floor that nobody has seen, and what
// has to be stepped over.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/floor_chunks.h"
#include "nav/ground.h"
#include "nav/planner_config.h"
#include "nav/walking/gait.h"

namespace headway::nav {

/// The ground of all cells, row-major.
struct GroundRaster {
  int width = 0, height = 0;
  const Ground* cells = nullptr;

  const Ground* row(int y) const {
    return cells + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  }
};

class FloorPrices {
 public:
  /// Throws InputError when near_range spans more than 250 cells, or corridor more than 125.
  FloorPrices(const PlannerConfig& config, const GaitLimits& gait, double resolution, double tick);

  /// Finds anew the prices of the rows and chunks (both inclusive, within the raster).
  void compute(const GroundRaster& ground, int first_row, int last_row, int first_chunk, int last_chunk,
               FloorChunks& into);

  /// What low ground adds when leaving its cell [ticks]; compute() leaves it out.
  Ticks low() const { return low_; }
  /// What unseen floor alone adds when leaving a cell straight or diagonally [ticks].
  Ticks unseen(const GroundRaster& ground, int x, int y, bool diagonal) const;

  /// Cells whose prices a cell has a part in reach so far from it.
  int reach() const { return std::max(range_, corridor_); }

  // For the sweep alone.
  using Prices = std::array<Ticks, 2>;
  int range() const { return range_; }
  int corridor() const { return corridor_; }
  const std::vector<Prices>& near_prices() const { return near_prices_; }
  const std::vector<Prices>& unseen_prices() const { return unseen_prices_; }

 private:
  int range_, corridor_;  ///< [cells]
  Ticks low_;
  std::vector<Prices> near_prices_, unseen_prices_;  ///< by squared distance [cells^2], by cells unseen
  std::vector<std::uint16_t> scratch_;
};

}  // namespace headway::nav
