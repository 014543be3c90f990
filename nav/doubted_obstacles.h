// Obstacles on the map of which it is worth seeing whether they are still there.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "nav/floor_map.h"
#include "nav/passing_obstacles.h"

namespace headway::nav {

class DoubtedObstacles {
 public:
  explicit DoubtedObstacles(const FloorGrid& grid) : doubted_(grid.size(), 0), stays_(grid.size(), 0) {}

  /// Takes in the floor (on the same grid) as it is now known: where it is free, what stood there has gone.
  void see(const FloorMap& floor);
  /// From now on, what came and what stands around it (the place that it came from) may have gone, and specks
  /// may be nothing, unless they are seen standing there at `since` or later.
  void doubt(const FloorMap& floor, const PassingObstacles& passing, Time since);
  /// The floor as it may be by now: in place of what may have gone, it is unseen. `hoped` is written over,
  /// whatever it was.
  void hope(const FloorMap& floor, const PassingObstacles& passing, FloorMap& hoped) const;
  /// Nothing is doubted any more; and what was seen standing there since will not be again.
  void believe(const FloorMap& floor, const PassingObstacles& passing);

 private:
  void doubt_speck(const FloorMap& floor, const Eigen::Vector2i& cell);
  void spread(const FloorMap& floor, std::vector<Eigen::Vector2i> front);

  std::vector<std::uint8_t> doubted_, stays_;  ///< FloorGrid::index
  Time since_{};
};

}  // namespace headway::nav
