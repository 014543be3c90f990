#include "nav/doubted_obstacles.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace headway::nav {
namespace {

using Eigen::Vector2i;

constexpr double kAround = 0.6;    // so far things that move reach [m]
constexpr std::size_t kSpeck = 4;  // cells that hang together and may be nothing

/// Calls visit(cell) for a cell's neighbours that lie on the grid, and for itself.
template <class Visit>
void for_each_around(const FloorGrid& grid, const Vector2i& cell, Visit&& visit) {
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x)
      if (const Vector2i near = cell + Vector2i(x, y); grid.contains(near)) visit(near);
}

}  // namespace

void DoubtedObstacles::see(const FloorMap& floor) {
  for (std::size_t i = 0; i < stays_.size(); ++i) stays_[i] &= floor.cells[i] != Floor::kFree;
}

void DoubtedObstacles::doubt(const FloorMap& floor, const PassingObstacles& passing, Time since) {
  since_ = since;
  std::fill(doubted_.begin(), doubted_.end(), std::uint8_t{0});
  const auto came = [&](const Vector2i& cell) {
    const std::size_t i = floor.grid.index(cell);
    return floor.cells[i] == Floor::kBlocked && passing.was_free(i) && !stays_[i];
  };
  std::vector<Vector2i> front;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      // Noise moves the borders of what stays by a cell; what comes is wider.
      int cells = 0;
      for_each_around(floor.grid, {x, y}, [&](const Vector2i& near) { cells += came(near); });
      if (cells < 9) continue;
      for_each_around(floor.grid, {x, y}, [&](const Vector2i& near) {
        if (!std::exchange(doubted_[floor.grid.index(near)], std::uint8_t{1})) front.push_back(near);
      });
    }
  }
  spread(floor, std::move(front));
  for (int y = 0; y < floor.grid.height; ++y)
    for (int x = 0; x < floor.grid.width; ++x) doubt_speck(floor, {x, y});
}

/// From afar, noise may have made what is so small.
void DoubtedObstacles::doubt_speck(const FloorMap& floor, const Vector2i& cell) {
  const auto blocked = [&](const Vector2i& c) { return floor.at(c) == Floor::kBlocked; };
  if (!blocked(cell) || stays_[floor.grid.index(cell)]) return;
  std::vector<Vector2i> speck{cell};
  for (std::size_t i = 0; i < speck.size() && speck.size() <= kSpeck; ++i) {
    for_each_around(floor.grid, Vector2i(speck[i]), [&](const Vector2i& near) {
      if (blocked(near) && std::find(speck.begin(), speck.end(), near) == speck.end()) speck.push_back(near);
    });
  }
  if (speck.size() <= kSpeck) doubted_[floor.grid.index(cell)] = 1;
}

/// To the blocked cells around, one after the other.
void DoubtedObstacles::spread(const FloorMap& floor, std::vector<Vector2i> front) {
  std::vector<Vector2i> next;
  for (int left = static_cast<int>(std::lround(kAround / floor.grid.resolution)); left > 0; --left) {
    next.clear();
    for (const Vector2i& cell : front) {
      for_each_around(floor.grid, cell, [&](const Vector2i& near) {
        const std::size_t i = floor.grid.index(near);
        if (floor.cells[i] != Floor::kBlocked || stays_[i]) return;
        if (!std::exchange(doubted_[i], std::uint8_t{1})) next.push_back(near);
      });
    }
    front.swap(next);
  }
}

void DoubtedObstacles::hope(const FloorMap& floor, const PassingObstacles& passing, FloorMap& hoped) const {
  hoped = floor;
  for (std::size_t i = 0; i < doubted_.size(); ++i)
    if (doubted_[i] && floor.cells[i] == Floor::kBlocked && passing.stood_at(i) < since_)
      hoped.cells[i] = Floor::kUnseen;
}

void DoubtedObstacles::believe(const FloorMap& floor, const PassingObstacles& passing) {
  for (std::size_t i = 0; i < doubted_.size(); ++i) {
    if (doubted_[i] && floor.cells[i] == Floor::kBlocked && passing.stood_at(i) >= since_) stays_[i] = 1;
    doubted_[i] = 0;
  }
}

}  // namespace headway::nav
