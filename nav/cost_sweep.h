// What the sweeps of the cost-to-goal work on: the costs, and what of them has changed and is still to be
// passed on.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "nav/floor_chunks.h"
#include "nav/motion_costs.h"

namespace headway::nav {

constexpr int kLayers = 2 * kHeadings;  ///< headings in forward mode, then in sideway mode
constexpr int layer_of(int heading, Mode mode) {
  return mode == Mode::kForward ? heading : kHeadings + heading;
}

/// A cell where a way may end.
struct Arrival {
  Eigen::Vector2i cell{0, 0};
  std::array<Ticks, kHeadings> cost{};  ///< by the heading there; kTooDear: not allowed

  bool operator==(const Arrival&) const = default;
};

/// From where to where, in cells.
struct CostQuery {
  Eigen::Vector2i start{0, 0};
  std::array<Ticks, kHeadings> start_cost{};  ///< to turn to each heading at the start; kTooDear: cannot
  std::vector<Arrival> goals;                 ///< one or more, each cell once: the cheapest to get to is it

  /// kTooDear where no way may end.
  Ticks arrival_cost(const Eigen::Vector2i& cell, int heading) const {
    const auto goal = std::ranges::find(goals, cell, &Arrival::cell);
    return goal == goals.end() ? kTooDear : goal->cost[static_cast<std::size_t>(heading)];
  }
};

struct alignas(64) CostChunk {
  Ticks cost[kLayers][kChunkCells];
};

/// Costs of all cells, and one chunk all around them that nobody reaches.
class CostTable {
 public:
  CostTable(int chunks, int height)
      : stride_(static_cast<std::size_t>(chunks) + 2),
        chunks_(stride_ * (static_cast<std::size_t>(height) + 2)) {
    for (CostChunk& c : chunks_) forget(c);
  }
  std::size_t index(int y, int i) const {
    return static_cast<std::size_t>(y + 1) * stride_ + static_cast<std::size_t>(i + 1);
  }
  CostChunk& at(int y, int i) { return chunks_[index(y, i)]; }
  const CostChunk& at(int y, int i) const { return chunks_[index(y, i)]; }
  CostChunk& operator[](std::size_t index) { return chunks_[index]; }
  static void forget(CostChunk& c) { std::memset(&c, 0xff, sizeof c); }  // kTooDear
  std::size_t size() const { return chunks_.size(); }

 private:
  std::size_t stride_;
  std::vector<CostChunk> chunks_;
};

/// For each chunk the least cost in it that changed and has not been passed on yet in some way; kTooDear:
/// none.
class Pending {
 public:
  Pending(int chunks, int height)
      : stride_(static_cast<std::size_t>((chunks + kChunkCells - 1) / kChunkCells * kChunkCells)),
        keys_(stride_ * static_cast<std::size_t>(height), kTooDear),
        lowest_(static_cast<std::size_t>(height), kTooDear) {}

  void note(int y, int i, Ticks cost) {
    Ticks& key = row(y)[i];
    key = std::min(key, cost);
    lowest(y) = std::min(lowest(y), cost);
  }
  /// Whole vectors of chunks; beyond the last one stands kTooDear.
  Ticks* row(int y) { return keys_.data() + static_cast<std::size_t>(y) * stride_; }
  int stride() const { return static_cast<int>(stride_); }
  Ticks& lowest(int y) { return lowest_[static_cast<std::size_t>(y)]; }
  bool any() const {
    return std::any_of(lowest_.begin(), lowest_.end(), [](Ticks t) { return t != kTooDear; });
  }
  void forget(int y, int i) { row(y)[i] = lowest(y) = kTooDear; }
  std::size_t bytes() const { return (keys_.size() + lowest_.size()) * sizeof(Ticks); }

 private:
  std::size_t stride_;
  std::vector<Ticks> keys_, lowest_;
};

/// A chunk by its place.
struct ChunkPlace {
  std::int32_t y, i;
};

struct CostSweep {
  CostSweep(const FloorChunks& floor_, const MotionCosts& costs_)
      : floor(floor_),
        costs(costs_),
        height(floor_.height()),
        chunks(floor_.chunks()),
        table(chunks, height),
        up(chunks, height),
        down(chunks, height),
        along(chunks, height),
        touched(table.size(), 0),
        asks(static_cast<std::size_t>(chunks) + 2, 0) {}

  const FloorChunks& floor;
  const MotionCosts& costs;
  int height, chunks;

  CostTable table;
  Pending up, down, along;  ///< to the row below (walks up), to the row above (walks down), along the row
  std::vector<std::uint8_t> touched;  ///< [CostTable::index]
  std::vector<ChunkPlace> touched_list;
  std::vector<std::uint8_t> asks;  ///< of the row in hand, from one chunk before it on

  /// The highest cost that is passed on grows by this much, in straight motions, while it is what keeps the
  /// start from being reached.
  static constexpr std::uint32_t kGrowth = 800;

  CostQuery query;
  std::uint32_t threshold = 0;          ///< costs from here on are not passed on yet
  int weight = 16;                      ///< sixteenths of the optimum that the result may cost
  std::size_t relaxed = 0, budget = 0;  ///< chunks worked on, and how many may be

  void touch(int y, int i) {
    std::uint8_t& known = touched[table.index(y, i)];
    if (!known) touched_list.push_back({y, i});
    known = 1;
  }

  /// What a goal costs in its own cell is to be passed on, where it is less than what is known.
  void set(const Arrival& goal) {
    const int y = goal.cell.y(), i = goal.cell.x() / kChunkCells, lane = goal.cell.x() % kChunkCells;
    for (int layer = 0; layer < kLayers; ++layer) {
      Ticks& known = table.at(y, i).cost[layer][lane];
      const Ticks cost = goal.cost[static_cast<std::size_t>(layer % kHeadings)];
      if (known <= cost) continue;
      known = cost;
      touch(y, i);
      if (y > 0) up.note(y, i, cost);
      if (y + 1 < height) down.note(y, i, cost);
      along.note(y, i, cost);
    }
  }

  /// What the goal costs from the start, as known so far.
  Ticks at_start() const {
    const CostChunk& chunk = table.at(query.start.y(), query.start.x() / kChunkCells);
    const int lane = query.start.x() % kChunkCells;
    Ticks best = kTooDear;
    for (int h = 0; h < kHeadings; ++h) {
      const Ticks on = std::min(chunk.cost[h][lane], chunk.cost[kHeadings + h][lane]);
      best = std::min(best, sum(query.start_cost[static_cast<std::size_t>(h)], on));
    }
    return best;
  }
  /// Changes are passed on when their cost and the least that the way from the start costs lie below.
  std::uint32_t bound() const {
    const auto known = static_cast<std::uint32_t>(at_start());
    if (known == kTooDear) return threshold;
    return std::min(threshold, known * 16 / static_cast<std::uint32_t>(weight) + 1);
  }
  /// At least so much costs the way from the start to any cell of a chunk.
  std::uint32_t least_from_start(int y, int i) const {
    const int first = i * kChunkCells, last = first + kChunkCells - 1, x = query.start.x();
    const int dx = std::max({first - x, x - last, 0}), dy = std::abs(y - query.start.y());
    return static_cast<std::uint32_t>(costs.least[0] * std::abs(dx - dy) +
                                      least_diagonal() * std::min(dx, dy));
  }
  /// ... and so much, at least, any way a cell on diagonally.
  int least_diagonal() const { return std::min<int>(costs.least[1], 2 * costs.least[0]); }
};

}  // namespace headway::nav
