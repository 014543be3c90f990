// What the goal costs from every state that matters: (cell, heading, mode), found by sweeping over the floor,
// sixteen cells of a layer at a time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "nav/cost_sweep.h"

namespace headway::nav {

/// A sweep up or down relaxes each row from the one just done, so that costs follow a way of any length until
/// it turns back; a few sweeps settle a floor. Only chunks are touched whose neighbours changed.
///
/// A change is not passed on where (its cost + the least that the way from the start to it costs) * w >
/// cost at the start. On the cheapest path, let s be the state nearest to the start whose exact cost was
/// found. If s is not the start, its change was not passed on, hence (C* w >= (cost(s) + least) w > cost at
/// the start), now or then, and that only falls: cost at the start <= w C*. With w = 1 every state on any
/// cheapest path gets its exact cost.
///
/// None of this asks where the sweeps began. So while the goals stay, the costs are kept from query to query,
/// with the changes that were not passed on: a start that moves costs next to nothing, and of a floor that
/// changes (see cost_repair.h) only what lies behind the change, as seen from the goal, is found anew.
class CostToGoal {
 public:
  /// Both must stay where they are. The floor may change between queries, its number of chunks may not.
  CostToGoal(const FloorChunks& floor, const MotionCosts& costs) : sweep_(floor, costs) {}

  /// To be told after each change of the floor.
  void floor_changed(const FloorChanges& changes);

  /// Goes on from what is known when the goals are those of the last query, else begins anew. `expected`:
  /// about what the goal should cost [ticks], which spares work when it is not too low; 0: nobody knows.
  void begin(const CostQuery& query, std::uint32_t expected = 0);

  /// Sweeps until the cost at the start is at most weight / 16 of the optimum: true; or until `budget` chunks
  /// have been worked on since begin() (looked at after each row): false. May go on with a lower weight or
  /// more budget.
  bool settle(int weight, std::size_t budget);

  /// Whether a floor has the number of chunks that this was made for.
  bool fits(const FloorChunks& floor) const {
    return floor.height() == sweep_.height && floor.chunks() == sweep_.chunks;
  }

  /// kTooDear before any way is found; never too low, and never rising while floor and query stay.
  Ticks at_start() const { return sweep_.at_start(); }
  Ticks at(int x, int y, int layer) const {
    return sweep_.table.at(y, x / kChunkCells).cost[layer][x % kChunkCells];
  }
  /// Chunks worked on since begin().
  std::size_t relaxed() const { return sweep_.relaxed; }
  std::size_t bytes() const;

 private:
  void forget();

  CostSweep sweep_;
};

}  // namespace headway::nav
