#include "nav/reachable.h"

#include <cstddef>

namespace headway::nav {

namespace {

/// The headings reached one cell on in a direction, from those reached here. Modes may be changed anywhere,
/// so a heading that is reached is reached in both.
unsigned headings_on(const FloorChunk& floor, int lane, int direction, unsigned headings) {
  unsigned reached = 0;
  for (int number = 0; number < kMotions; ++number) {
    const Motion m{(direction - Motion{0, number}.turn()) & 7, number};
    const bool blocked = floor.blocked[static_cast<std::size_t>(slot_of(m))] >> lane & 1;
    if ((headings >> m.heading & 1) && !blocked) reached |= 1u << m.heading_after();
  }
  return reached;
}

}  // namespace

std::vector<std::uint8_t> reachable_headings(const FloorChunks& floor, const Eigen::Vector2i& start,
                                             unsigned headings) {
  const int width = floor.width();
  std::vector<std::uint8_t> reached(
      static_cast<std::size_t>(width) * static_cast<std::size_t>(floor.height()), 0);
  std::vector<std::int32_t> open;
  const auto reach = [&](int cell, unsigned more) {
    std::uint8_t& known = reached[static_cast<std::size_t>(cell)];
    if ((more & ~static_cast<unsigned>(known)) == 0) return;
    known = static_cast<std::uint8_t>(known | more);
    open.push_back(cell);
  };
  reach(start.y() * width + start.x(), headings);
  while (!open.empty()) {
    const int cell = open.back(), x = cell % width, y = cell / width;
    open.pop_back();
    const FloorChunk& chunk = floor.row(y)[x / kChunkCells];
    for (int direction = 0; direction < kHeadings; ++direction) {
      const unsigned on =
          headings_on(chunk, x % kChunkCells, direction, reached[static_cast<std::size_t>(cell)]);
      const Eigen::Vector2i way = cell_towards(direction);
      if (on != 0) reach(cell + way.y() * width + way.x(), on);
    }
  }
  return reached;
}

}  // namespace headway::nav
