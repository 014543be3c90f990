// Floors for the planner's tests: rooms with boxes, the same for the same seed.
#pragma once

#include <cstdint>
#include <random>

#include "nav/floor_map.h"

namespace headway::nav {

inline FloorMap free_floor(int width, int height, double resolution) {
  FloorMap map;
  map.grid = {resolution, {-0.7, 0.3}, width, height};
  map.cells.assign(map.grid.size(), Floor::kFree);
  map.seen_at.assign(map.grid.size(), Time{});
  return map;
}

inline void fill(FloorMap& map, Eigen::Vector2i low, Eigen::Vector2i high, Floor with) {
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      if (map.grid.contains({x, y})) map.cells[map.grid.index({x, y})] = with;
    }
  }
}

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  /// lowest <= n < beyond
  int whole(int lowest, int beyond) {
    return lowest + static_cast<int>(engine_() % static_cast<std::uint64_t>(beyond - lowest));
  }
  double real(double lowest, double highest) {
    return lowest + (highest - lowest) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }

 private:
  std::mt19937_64 engine_;
};

/// Boxes, single blocked cells and unseen patches, about as many as leave a way through.
inline FloorMap random_floor(int width, int height, double resolution, Dice& dice) {
  FloorMap map = free_floor(width, height, resolution);
  const auto patch = [&](Floor with, int most) {
    const Eigen::Vector2i low(dice.whole(0, width), dice.whole(0, height));
    fill(map, low, low + Eigen::Vector2i(dice.whole(0, most), dice.whole(0, most)), with);
  };
  const int unseen = dice.whole(0, 4), boxes = dice.whole(0, 6), walls = dice.whole(0, 3);
  for (int i = 0; i < unseen; ++i) patch(Floor::kUnseen, width / 3);
  for (int i = 0; i < boxes; ++i) patch(Floor::kBlocked, 6);
  for (int i = 0; i < walls; ++i) {
    const int x = dice.whole(0, width), gap = dice.whole(0, height), wide = dice.whole(5, 16);
    fill(map, {x, 0}, {x, gap}, Floor::kBlocked);
    fill(map, {x, gap + wide}, {x, height}, Floor::kBlocked);
  }
  return map;
}

}  // namespace headway::nav
