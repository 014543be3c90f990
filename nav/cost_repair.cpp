#include "nav/cost_repair.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/cost_repair.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "nav/cost_lanes.inl"

// Everything above HWY_ONCE is compiled once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace headway::nav::HWY_NAMESPACE {
namespace {

/// The least cost in a chunk, in any of its layers; kTooDear: none.
HWY_INLINE Ticks least_in(const CostChunk& chunk) {
  Cells best = load(chunk.cost[0]);
  for (int l = 1; l < kLayers; ++l) best = least(best, load(chunk.cost[l]));
  return lowest(best);
}

/// The least cost of some of a chunk's cells.
Ticks least_of_cells(const CostChunk& chunk, std::uint16_t cells) {
  Cells best = load(chunk.cost[0]);
  for (int l = 1; l < kLayers; ++l) best = least(best, load(chunk.cost[l]));
  return lowest(barred(best, static_cast<std::uint16_t>(~cells)));
}

/// Forgets the costs of a chunk that are not below the limit, but for what a change of mode makes of the
/// others: sweeps do that only together with a motion. Returns whether there were any; `left`: the least of
/// the others.
HWY_INLINE bool forget_from(CostChunk& chunk, Cells limit, Cells mode_change, Ticks& left) {
  Cells lost = all_of(0), best = all_of(kTooDear);
  for (int h = 0; h < kHeadings; ++h) {
    const Cells old_forward = load(chunk.cost[h]), old_sideway = load(chunk.cost[kHeadings + h]);
    const Cells forward = where_below(old_forward, limit), sideway = where_below(old_sideway, limit);
    lost = either(lost, either(gain(forward, old_forward), gain(sideway, old_sideway)));
    best = least(best, least(forward, sideway));
    store(least(forward, plus(sideway, mode_change)), chunk.cost[h]);
    store(least(sideway, plus(forward, mode_change)), chunk.cost[kHeadings + h]);
  }
  left = lowest(best);
  return !none(lost);
}

class Repair {
 public:
  explicit Repair(CostSweep& s) : s_(s) {}

  void run(const std::vector<ChunkChange>& changes) {
    Ticks limit = kTooDear;
    for (const ChunkChange& c : changes)
      if (c.raised != 0) limit = std::min(limit, least_of_cells(s_.table.at(c.y, c.i), c.raised));
    if (limit != kTooDear) forget(limit);
    for (const ChunkChange& c : changes)
      if (c.lowered) look_again(c.y, c.i, [&](int y, int i) { return least_in(s_.table.at(y, i)); });
  }

 private:
  void forget(Ticks limit) {
    const Cells limits = all_of(limit), mode_change = all_of(s_.costs.mode_change);
    std::vector<ChunkPlace> forgotten;
    std::vector<Ticks> left(s_.table.size(), kTooDear);
    for (const ChunkPlace& c : s_.touched_list)
      if (forget_from(s_.table.at(c.y, c.i), limits, mode_change, left[s_.table.index(c.y, c.i)]))
        forgotten.push_back(c);
    // What was forgotten costs no less than the limit when it is found again, or less by way of a change that
    // was not passed on yet and that has been noted. A step on, the way from the start may be shorter by as
    // much.
    const auto step = std::min<Ticks>(limit, static_cast<Ticks>(s_.least_diagonal()));
    const auto least_again = static_cast<Ticks>(limit - step);
    for (const ChunkPlace& c : forgotten) {
      look_again(c.y, c.i, [&](int y, int i) { return std::max(left[s_.table.index(y, i)], least_again); });
    }
  }

  /// What lies in and around a chunk is to be passed on, as if it had changed.
  template <class LeastIn>
  void look_again(int y, int i, const LeastIn& least) {
    for (int row = std::max(0, y - 1); row <= std::min(s_.height - 1, y + 1); ++row) {
      Pending& pending = row > y ? s_.up : row < y ? s_.down : s_.along;
      for (int n = std::max(0, i - 1); n <= std::min(s_.chunks - 1, i + 1); ++n)
        if (const Ticks cost = least(row, n); cost != kTooDear) pending.note(row, n, cost);
    }
  }

  CostSweep& s_;
};

void repair_costs(CostSweep& s, const std::vector<ChunkChange>& changes) { Repair(s).run(changes); }

}  // namespace
}  // namespace headway::nav::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(repair_costs);

}  // namespace

void repair(CostSweep& sweep, const std::vector<ChunkChange>& changes) {
  HWY_DYNAMIC_DISPATCH(repair_costs)(sweep, changes);
}

}  // namespace headway::nav
#endif
