// The floor as the search reads it: which motions are blocked from each cell and what its floor adds to their
// cost, sixteen cells of a row at a time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/motion_costs.h"

namespace headway::nav {

constexpr int kChunkCells = 16;
constexpr int kBlockChunks = 16;  ///< chunks whose motions are found together
constexpr int kBlockCells = kBlockChunks * kChunkCells;

/// Motions by where they go: those of one direction stand side by side.
constexpr int slot_of(int direction, int number) { return direction * kMotions + number; }
inline int slot_of(const Motion& m) { return slot_of(m.direction(), m.number); }

/// Whether motions are free in a chunk: none of any cell, some, or all of all cells.
enum class Passage : std::uint8_t { kClosed, kPartly, kOpen };

struct FloorChunk {
  std::array<std::uint16_t, kConfigurations> blocked;   ///< [slot], bit i: from cell i
  std::array<std::array<Ticks, kChunkCells>, 2> price;  ///< added when leaving the cell [diagonally][cell]
};

/// How a chunk's floor has changed.
struct ChunkChange {
  std::int32_t y, i;     ///< the chunk's row, and its number there
  std::uint16_t raised;  ///< cells, a bit each, from which something costs more than before
  bool lowered;          ///< from some cell something costs less
};

/// What has changed between two states of a floor.
struct FloorChanges {
  bool everything = false;  ///< nothing that was known holds
  std::vector<ChunkChange> chunks;
};

/// Row-major; rows are rounded up to whole blocks, and from cells beyond the width every motion is blocked.
class FloorChunks {
 public:
  /// Everything blocked.
  void reset(int width, int height) {
    width_ = width;
    height_ = height;
    stride_ = (width + kBlockCells - 1) / kBlockCells * kBlockChunks;
    const std::size_t chunks = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height);
    FloorChunk closed{};
    closed.blocked.fill(0xffff);
    chunks_.assign(chunks, closed);
    passage_.assign(chunks, Passage::kClosed);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  int chunks() const { return (width_ + kChunkCells - 1) / kChunkCells; }  ///< of a row
  int blocks() const { return stride_ / kBlockChunks; }                    ///< of a row

  FloorChunk* row(int y) { return chunks_.data() + first(y); }
  const FloorChunk* row(int y) const { return chunks_.data() + first(y); }
  Passage* passage(int y) { return passage_.data() + first(y); }
  const Passage* passage(int y) const { return passage_.data() + first(y); }

  bool blocked(int x, int y, const Motion& m) const { return blocked(x, y, slot_of(m)); }
  bool blocked(int x, int y, int slot) const {
    return (row(y)[x / kChunkCells].blocked[static_cast<std::size_t>(slot)] >> (x % kChunkCells) & 1) != 0;
  }
  Ticks price(int x, int y, bool diagonal) const {
    return row(y)[x / kChunkCells].price[diagonal ? 1 : 0][static_cast<std::size_t>(x % kChunkCells)];
  }
  std::size_t bytes() const { return chunks_.size() * (sizeof(FloorChunk) + sizeof(Passage)); }

 private:
  std::size_t first(int y) const { return static_cast<std::size_t>(y) * static_cast<std::size_t>(stride_); }

  int width_ = 0, height_ = 0, stride_ = 0;
  std::vector<FloorChunk> chunks_;
  std::vector<Passage> passage_;
};

}  // namespace headway::nav
