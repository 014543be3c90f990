#include "nav/reachable.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace headway::nav {

namespace {

using Cells = std::uint16_t;  ///< a bit for each cell of a chunk

/// By heading. Modes may be changed anywhere, so a heading that is reached is reached in both.
using Reached = std::array<Cells, kHeadings>;

/// Sixteen cells at once: what is reached spreads from chunk to chunk, up and down the floor until all is.
class Spread {
 public:
  explicit Spread(const FloorChunks& floor)
      : floor_(floor),
        chunks_(floor.chunks()),
        reached_(static_cast<std::size_t>(chunks_) * static_cast<std::size_t>(floor.height())),
        news_(reached_.size(), false) {}

  void from(const Eigen::Vector2i& cell, unsigned headings) {
    for (std::size_t h = 0; h < kHeadings; ++h)
      if (headings >> h & 1) reach(cell.y(), cell.x() / kChunkCells, h, bit(cell.x() % kChunkCells));
    const int height = floor_.height();
    for (bool up = true; left_ > 0; up = !up)
      for (int n = 0; n < height; ++n) spread_row(up ? n : height - 1 - n);
  }

  std::vector<std::uint8_t> headings_of_cells() const {
    const auto width = static_cast<std::size_t>(floor_.width());
    std::vector<std::uint8_t> headings(width * static_cast<std::size_t>(floor_.height()), 0);
    for (std::size_t at = 0; at < reached_.size(); ++at) {
      if (reached_[at] == Reached{}) continue;
      const std::size_t y = at / static_cast<std::size_t>(chunks_),
                        i = at % static_cast<std::size_t>(chunks_);
      const std::size_t first = i * kChunkCells, cells = std::min<std::size_t>(kChunkCells, width - first);
      for (std::size_t cell = 0; cell < cells; ++cell) {
        unsigned bits = 0;
        for (std::size_t h = 0; h < kHeadings; ++h) bits |= (unsigned{reached_[at][h]} >> cell & 1) << h;
        headings[y * width + first + cell] = static_cast<std::uint8_t>(bits);
      }
    }
    return headings;
  }

 private:
  static Cells bit(int lane) { return static_cast<Cells>(1u << lane); }
  std::size_t index(int y, int i) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(chunks_) + static_cast<std::size_t>(i);
  }

  void spread_row(int y) {
    for (int i = 0; i < chunks_; ++i) {
      while (news_[index(y, i)]) {
        news_[index(y, i)] = false;
        --left_;
        for (int direction = 0; direction < kHeadings; ++direction) walk(y, i, direction);
      }
    }
  }

  /// One cell on in a direction, from all that is reached of a chunk.
  void walk(int y, int i, int direction) {
    const FloorChunk& floor = floor_.row(y)[i];
    const Reached& here = reached_[index(y, i)];
    Reached on{};
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{(direction - Motion{0, number}.turn()) & 7, number};
      const auto before = static_cast<std::size_t>(m.heading),
                 after = static_cast<std::size_t>(m.heading_after());
      const unsigned free = here[before] & ~unsigned{floor.blocked[static_cast<std::size_t>(slot_of(m))]};
      on[after] = static_cast<Cells>(on[after] | free);
    }
    const Eigen::Vector2i way = cell_towards(direction);
    for (std::size_t h = 0; h < kHeadings; ++h) {
      if (on[h] == 0) continue;
      const unsigned cells = way.x() > 0 ? unsigned{on[h]} << 1 : way.x() < 0 ? unsigned{on[h]} >> 1 : on[h];
      reach(y + way.y(), i, h, static_cast<Cells>(cells));
      if (way.x() > 0 && (on[h] & bit(kChunkCells - 1))) reach(y + way.y(), i + 1, h, bit(0));
      if (way.x() < 0 && (on[h] & bit(0))) reach(y + way.y(), i - 1, h, bit(kChunkCells - 1));
    }
  }

  /// No free motion leads out of the floor.
  void reach(int y, int i, std::size_t heading, Cells cells) {
    const std::size_t at = index(y, i);
    Cells& known = reached_[at][heading];
    if ((cells & ~unsigned{known}) == 0) return;
    known = static_cast<Cells>(known | cells);
    left_ += !news_[at];
    news_[at] = true;
  }

  const FloorChunks& floor_;
  int chunks_;
  std::vector<Reached> reached_;
  std::vector<std::uint8_t> news_;  ///< whether a chunk has some that have not been spread
  std::size_t left_ = 0;            ///< such chunks
};

}  // namespace

std::vector<std::uint8_t> reachable_headings(const FloorChunks& floor, const Eigen::Vector2i& start,
                                             unsigned headings) {
  Spread spread(floor);
  spread.from(start, headings);
  return spread.headings_of_cells();
}

}  // namespace headway::nav
