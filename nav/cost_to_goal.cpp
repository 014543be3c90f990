#include "nav/cost_to_goal.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/cost_to_goal.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "nav/cost_relax.inl"
#include "nav/cost_repair.h"

// Everything above HWY_ONCE is compiled once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace headway::nav::HWY_NAMESPACE {
namespace {

/// Which way a sweep's walks go: its rows are done the other way round.
enum class Walks { kUp, kDown };

class Sweeper {
 public:
  explicit Sweeper(CostSweep& s)
      : s_(s), motions_(s.costs), marked_(static_cast<std::size_t>((s.chunks + 63) / 64) + 2, 0) {}

  /// False when the budget ran out. `any`: whether anything was passed on.
  template <Walks walks>
  HWY_INLINE bool sweep(bool& any) {
    constexpr bool kUp = walks == Walks::kUp;
    Pending& pending = kUp ? s_.up : s_.down;
    for (int n = 0; n < s_.height; ++n) {
      const int y = kUp ? s_.height - 1 - n : n, there = kUp ? y + 1 : y - 1;
      bound_ = s_.bound();
      first_ = s_.chunks;
      last_ = -1;
      if (there >= 0 && there < s_.height && reaches(pending.lowest(there), there) && mark(pending, there)) {
        any = true;
        relax_row<walks>(y, there);
      }
      any |= take(s_.along, y, [this](int i) HWY_ATTR {
        ask(i, kAskEast | kAskWest | kAskEastOfPrevious | kAskWestOfNext);
      });
      if (last_ >= 0) chains(y);
      if (s_.relaxed >= s_.budget) return false;
    }
    return true;
  }

 private:
  HWY_INLINE bool matters(Ticks cost, int y, int i) const {
    return cost < bound_ && cost + s_.least_from_start(y, i) < bound_;
  }
  HWY_INLINE bool reaches(Ticks lowest, int y) const {
    const auto rows = static_cast<std::uint32_t>(std::abs(y - s_.query.start.y()));
    return lowest + rows * s_.costs.least[0] < bound_ && lowest != kTooDear;
  }

  /// Calls `use` with each chunk of a row that has something pending which matters, and forgets that.
  template <class Use>
  HWY_INLINE bool take(Pending& pending, int y, const Use& use) {
    if (!reaches(pending.lowest(y), y)) return false;
    Ticks* keys = pending.row(y);
    const auto limit = static_cast<Ticks>(std::min<std::uint32_t>(bound_, kTooDear));
    bool any = false;
    Cells left = all_of(kTooDear);
    for (int first = 0; first < pending.stride(); first += kChunkCells) {
      for (unsigned bits = below(load(keys + first), limit); bits != 0; bits &= bits - 1) {
        const int i = first + std::countr_zero(bits);
        if (keys[i] + s_.least_from_start(y, i) >= bound_) continue;
        keys[i] = kTooDear;
        any = true;
        use(i);
      }
      left = least(left, load(keys + first));
    }
    pending.lowest(y) = lowest(left);
    return any;
  }

  HWY_INLINE bool mark(Pending& pending, int row) {
    std::fill(marked_.begin(), marked_.end(), 0);
    return take(pending, row, [this](int i) HWY_ATTR {
      marked_[static_cast<std::size_t>(i / 64) + 1] |= std::uint64_t{1} << (i % 64);
    });
  }

  /// The chunks of a row beside, and diagonally beside, the marked ones of the row where they lead.
  template <Walks walks>
  HWY_INLINE void relax_row(int y, int there) {
    const FloorChunk* floor = s_.floor.row(y);
    const Passage* passage = s_.floor.passage(y);
    for (std::size_t w = 1; w + 1 < marked_.size(); ++w) {
      std::uint64_t bits =
          marked_[w] | marked_[w] << 1 | marked_[w] >> 1 | marked_[w - 1] >> 63 | marked_[w + 1] << 63;
      for (; bits != 0; bits &= bits - 1) {
        const int i = 64 * (static_cast<int>(w) - 1) + std::countr_zero(bits);
        if (i >= s_.chunks || passage[i] == Passage::kClosed) continue;
        ++s_.relaxed;
        constexpr int kFirst = walks == Walks::kUp ? 1 : 5;
        const CostChunk* from = &s_.table.at(there, i);
        CostChunk& here = s_.table.at(y, i);
        const Change change = passage[i] == Passage::kOpen
                                  ? relax_from_row<kFirst, true>(motions_, floor[i], from, here)
                                  : relax_from_row<kFirst, false>(motions_, floor[i], from, here);
        note(y, i, change);
      }
    }
  }

  /// A chunk has changed: who is to look at it?
  HWY_INLINE void note(int y, int i, const Change& change) {
    if (change.lowest == kTooDear) return;
    s_.touch(y, i);
    if (y > 0) s_.up.note(y, i, change.lowest);
    if (y + 1 < s_.height) s_.down.note(y, i, change.lowest);
    if (matters(change.lowest, y, i))
      ask(i, change.asks);
    else
      s_.along.note(y, i, change.lowest);
  }

  HWY_INLINE std::uint8_t& asks(int i) { return s_.asks[static_cast<std::size_t>(i + 1)]; }
  HWY_INLINE void ask(int i, unsigned what) {
    asks(i) = static_cast<std::uint8_t>(asks(i) | what);
    first_ = std::min(first_, i);
    last_ = std::max(last_, i);
  }
  HWY_INLINE bool take_ask(int i, unsigned what) {
    const bool asked = (asks(i) & what) != 0;
    asks(i) = static_cast<std::uint8_t>(asks(i) & ~what);
    return asked;
  }

  /// Chains within a row, to and fro until nobody asks for one.
  HWY_INLINE void chains(int y) {
    const int last_chunk = s_.chunks - 1;
    do {
      again_ = false;
      for (int i = std::min(last_, last_chunk); i >= std::max(0, first_ - 1); --i) {
        const bool own = take_ask(i, kAskEast), next = take_ask(i + 1, kAskEastOfPrevious);
        if (own || next) relax_along<Way::kEast>(y, i);
      }
      take_ask(0, kAskEastOfPrevious);
      for (int i = std::max(0, first_ - 1); i <= std::min(last_ + 1, last_chunk); ++i) {
        const bool own = take_ask(i, kAskWest), previous = take_ask(i - 1, kAskWestOfNext);
        if (own || previous) relax_along<Way::kWest>(y, i);
      }
      take_ask(last_chunk, kAskWestOfNext);
    } while (again_);
  }

  template <Way way>
  HWY_INLINE void relax_along(int y, int i) {
    const Passage passage = s_.floor.passage(y)[i];
    if (passage == Passage::kClosed) return;
    ++s_.relaxed;
    const FloorChunk& floor = s_.floor.row(y)[i];
    CostChunk* here = &s_.table.at(y, i);
    const Change change = passage == Passage::kOpen ? RowRelaxation<way, true>(motions_, floor, here).run()
                                                    : RowRelaxation<way, false>(motions_, floor, here).run();
    note(y, i, change);
    // What is asked of the east while going west has to wait for the next round.
    if (way == Way::kWest && change.lowest != kTooDear)
      again_ |= (change.asks & (kAskEast | kAskEastOfPrevious)) != 0;
  }

  CostSweep& s_;
  const MotionLanes motions_;
  std::vector<std::uint64_t> marked_;  // chunks of the row where walks lead, a word before and one behind
  std::uint32_t bound_ = 0;
  int first_ = 0, last_ = -1;  // chunks of the row in hand that ask for chains
  bool again_ = false;
};

bool settle_sweeps(CostSweep& s) {
  Sweeper sweeper(s);
  bool up = s.query.start.y() < s.query.goals.front().cell.y();
  for (int idle = 0;; up = !up) {
    bool any = false;
    if (!(up ? sweeper.sweep<Walks::kUp>(any) : sweeper.sweep<Walks::kDown>(any))) return false;
    idle = any ? 0 : idle + 1;
    if (idle < 2) continue;
    if (s.bound() < s.threshold || !(s.up.any() || s.down.any() || s.along.any())) return true;
    s.threshold += std::max(CostSweep::kGrowth * s.costs.least[0], s.threshold / 4);
    idle = 0;
  }
}

}  // namespace
}  // namespace headway::nav::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(settle_sweeps);

}  // namespace

void CostToGoal::forget() {
  CostSweep& s = sweep_;
  for (const ChunkPlace& c : s.touched_list) {
    CostTable::forget(s.table.at(c.y, c.i));
    s.touched[s.table.index(c.y, c.i)] = 0;
    for (Pending* p : {&s.up, &s.down, &s.along}) p->forget(c.y, c.i);
  }
  s.touched_list.clear();
  s.query.goals.clear();
}

void CostToGoal::floor_changed(const FloorChanges& changes) {
  if (changes.everything)
    forget();
  else
    repair(sweep_, changes.chunks);
}

void CostToGoal::begin(const CostQuery& query, std::uint32_t expected) {
  CostSweep& s = sweep_;
  if (s.query.goals != query.goals) forget();
  s.query = query;
  s.weight = 16;
  s.relaxed = 0;
  for (const Arrival& goal : query.goals) s.set(goal);
  const std::uint32_t growth = CostSweep::kGrowth * s.costs.least[0];
  const Eigen::Vector2i& first = query.goals.front().cell;
  s.threshold = expected > 0 ? expected : s.least_from_start(first.y(), first.x() / kChunkCells) + growth;
}

bool CostToGoal::settle(int weight, std::size_t budget) {
  sweep_.weight = weight;
  sweep_.budget = budget;
  return HWY_DYNAMIC_DISPATCH(settle_sweeps)(sweep_);
}

std::size_t CostToGoal::bytes() const {
  return sweep_.table.size() * (sizeof(CostChunk) + 1) + sweep_.up.bytes() + sweep_.down.bytes() +
         sweep_.along.bytes() + sweep_.touched_list.capacity() * sizeof(ChunkPlace);
}

}  // namespace headway::nav
#endif
