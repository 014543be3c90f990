// The costs of a chunk made from those of its neighbours.
//
// Compiled once for each instruction set (see Highway's foreach_target), hence no ordinary include guard.
#if defined(HEADWAY_COST_RELAX_TOGGLE) == defined(HWY_TARGET_TOGGLE)
#ifdef HEADWAY_COST_RELAX_TOGGLE
#undef HEADWAY_COST_RELAX_TOGGLE
#else
#define HEADWAY_COST_RELAX_TOGGLE
#endif

#include <cstdint>

#include "nav/cost_lanes.inl"
#include "nav/cost_sweep.h"

HWY_BEFORE_NAMESPACE();
namespace headway::nav::HWY_NAMESPACE {
namespace {

// What a change asks for: chains to the east and west of the chunk itself, and of its neighbours.
constexpr unsigned kAskEast = 1, kAskWest = 2, kAskEastOfPrevious = 4, kAskWestOfNext = 8;

struct Change {
  Ticks lowest;  ///< of the costs that changed; kTooDear: none did
  unsigned asks;
};

constexpr int turn_of(int number) { return Motion{0, number}.turn(); }
constexpr int heading_before(int direction, int number) { return (direction - turn_of(number)) & 7; }
constexpr std::size_t eighths_of(int number) {
  return static_cast<std::size_t>(turn_of(number) < 0 ? -turn_of(number) : turn_of(number));
}

/// Costs of motions, spread over lanes.
struct MotionLanes {
  Cells forward[2][3], sideway[2][3], mode_change;
  explicit MotionLanes(const MotionCosts& c) : mode_change(all_of(c.mode_change)) {
    for (std::size_t diagonal = 0; diagonal < 2; ++diagonal) {
      for (std::size_t eighths = 0; eighths < 3; ++eighths) {
        forward[diagonal][eighths] = all_of(c.forward[diagonal][eighths]);
        sideway[diagonal][eighths] = all_of(c.sideway[diagonal][eighths]);
      }
    }
  }
};

template <bool kOpen>
HWY_INLINE Cells where_free(Cells v, const FloorChunk& floor, int slot) {
  if constexpr (kOpen) return v;
  return barred(v, floor.blocked[static_cast<std::size_t>(slot)]);
}

/// The costs one cell on in a direction, of the chunks of the row where it leads.
template <int direction>
HWY_INLINE Cells costs_on(const CostChunk* there, int layer) {
  const Cells v = load(there->cost[layer]);
  constexpr int dx = direction == 0 || direction == 1 || direction == 7 ? 1
                     : direction == 2 || direction == 6                 ? 0
                                                                        : -1;
  if constexpr (dx > 0) return neighbours<Way::kEast>(v, load(there[1].cost[layer]));
  if constexpr (dx < 0) return neighbours<Way::kWest>(v, load(there[-1].cost[layer]));
  return v;
}

/// What the motions of one direction make of the costs where they lead: the best by the heading before.
template <int direction, bool kOpen>
HWY_INLINE void relax_direction(const MotionLanes& motions, const FloorChunk& floor, const CostChunk* there,
                                Cells* forward, Cells* sideway) {
  constexpr int diagonal = direction % 2;
  const Cells price = load(floor.price[diagonal].data());
  const Cells on = plus(costs_on<direction>(there, direction), price);
  const Cells by_turn[] = {plus(on, motions.forward[diagonal][0]), plus(on, motions.forward[diagonal][1]),
                           plus(on, motions.forward[diagonal][2])};
  HWY_UNROLL(5)
  for (int number = 0; number < kForwardMotions; ++number) {
    Cells& best = forward[heading_before(direction, number)];
    best = least(best, where_free<kOpen>(by_turn[eighths_of(number)], floor, slot_of(direction, number)));
  }
  HWY_UNROLL(4)
  for (int number = kForwardMotions; number < kMotions; ++number) {
    const int heading = heading_before(direction, number);
    const Cells cost = plus(plus(costs_on<direction>(there, kHeadings + heading), price),
                            motions.sideway[diagonal][eighths_of(number)]);
    sideway[heading] = least(sideway[heading], where_free<kOpen>(cost, floor, slot_of(direction, number)));
  }
}

/// A chunk from the row that its motions of three directions lead to. `there`: the chunk beside it in that
/// row.
template <int first_direction, bool kOpen>
HWY_INLINE Change relax_from_row(const MotionLanes& motions, const FloorChunk& floor, const CostChunk* there,
                                 CostChunk& here) {
  const Cells never = all_of(kTooDear);
  Cells forward[kHeadings], sideway[kHeadings];
  HWY_UNROLL(8)
  for (int h = 0; h < kHeadings; ++h) forward[h] = sideway[h] = never;
  relax_direction<first_direction, kOpen>(motions, floor, there, forward, sideway);
  relax_direction<first_direction + 1, kOpen>(motions, floor, there, forward, sideway);
  relax_direction<first_direction + 2, kOpen>(motions, floor, there, forward, sideway);
  Cells news = never;
  HWY_UNROLL(8)
  for (int h = 0; h < kHeadings; ++h) {
    const Cells old_forward = load(here.cost[h]), old_sideway = load(here.cost[kHeadings + h]);
    const Cells new_forward = least(old_forward, least(forward[h], plus(sideway[h], motions.mode_change)));
    const Cells new_sideway = least(old_sideway, least(sideway[h], plus(forward[h], motions.mode_change)));
    news = least(news, least(changed(new_forward, old_forward), changed(new_sideway, old_sideway)));
    store(new_forward, here.cost[h]);
    store(new_sideway, here.cost[kHeadings + h]);
  }
  const unsigned edges =
      (first_of(news) != kTooDear ? kAskEastOfPrevious : 0) | (last_of(news) != kTooDear ? kAskWestOfNext : 0);
  return {lowest(news), kAskEast | kAskWest | edges};
}

/// Costs of a row of cells when motions of the given price lead from each to its neighbour, `beyond` the last
/// of them. With the cost that comes in, sixteen cells take five steps.
template <Way way>
HWY_INLINE Cells chain(Cells v, Cells price, Cells beyond) {
  v = least(v, plus(price, neighbours<way>(v, beyond)));
  v = least(v, plus(price, cells_on<way, 1>(v)));
  price = plus(price, cells_on<way, 1>(price));
  v = least(v, plus(price, cells_on<way, 2>(v)));
  price = plus(price, cells_on<way, 2>(price));
  v = least(v, plus(price, cells_on<way, 4>(v)));
  price = plus(price, cells_on<way, 4>(price));
  return least(v, plus(price, cells_on<way, 8>(v)));
}

/// The motions within a row, all one way.
template <Way way, bool kOpen>
class RowRelaxation {
 public:
  RowRelaxation(const MotionLanes& motions, const FloorChunk& floor, CostChunk* here)
      : motions_(motions),
        floor_(floor),
        here_(*here),
        beyond_(way == Way::kEast ? here[1] : here[-1]),
        price_(load(floor.price[0].data())),
        news_(all_of(kTooDear)),
        news_of_both_(news_) {}

  HWY_INLINE Change run() {
    forward();
    sideway();
    const Ticks lowest_news = lowest(news_);
    if (lowest_news == kTooDear) return {kTooDear, 0};
    const bool both = lowest(news_of_both_) != kTooDear;
    const unsigned previous = first_of(news_) != kTooDear ? kAskEastOfPrevious : 0,
                   next = last_of(news_) != kTooDear ? kAskWestOfNext : 0;
    if (way == Way::kEast) return {lowest_news, both ? kAskWest | previous | next : previous};
    return {lowest_news, both ? kAskEast | previous | next : next};
  }

 private:
  static constexpr int kDirection = way == Way::kEast ? 0 : 4;
  static constexpr int slot(int number) { return slot_of(kDirection, number); }

  HWY_INLINE Cells layer(int l) const { return load(here_.cost[l]); }
  HWY_INLINE Cells on(Cells v, int l) const { return neighbours<way>(v, load(beyond_.cost[l])); }

  /// Straight on as far as it goes, then with a turn before.
  HWY_INLINE void forward() {
    const Cells step = plus(price_, motions_.forward[0][0]);
    Cells v = layer(kDirection);
    if (!none(gain(v, plus(on(v, kDirection), step)))) {
      v = chain<way>(v, where_free<kOpen>(step, floor_, slot(2)), load(beyond_.cost[kDirection]));
      put(kDirection, v);
      put(kHeadings + kDirection, plus(v, motions_.mode_change));
    }
    const Cells next = plus(on(v, kDirection), price_);
    const Cells by_turn[] = {next, plus(next, motions_.forward[0][1]), plus(next, motions_.forward[0][2])};
    const auto gain_of = [&](int number) HWY_ATTR {
      return gain(layer(heading_before(kDirection, number)), by_turn[eighths_of(number)]);
    };
    // Mostly nothing is to be gained, whether blocked or not.
    if (none(either(either(gain_of(0), gain_of(1)), either(gain_of(3), gain_of(4))))) return;
    const auto turn = [&](int number) HWY_ATTR {
      const int heading = heading_before(kDirection, number);
      const Cells cost = where_free<kOpen>(by_turn[eighths_of(number)], floor_, slot(number));
      put(heading, cost);
      put(kHeadings + heading, plus(cost, motions_.mode_change));
    };
    turn(0), turn(1), turn(3), turn(4);
  }

  HWY_INLINE void sideway() {
    const Cells steps[] = {plus(price_, motions_.sideway[0][1]), plus(price_, motions_.sideway[0][2])};
    const auto step = [&](int number) HWY_ATTR { return steps[eighths_of(number) - 1]; };
    const auto gain_of = [&](int number) HWY_ATTR {
      const int l = kHeadings + heading_before(kDirection, number);
      const Cells v = layer(l);
      return gain(v, plus(on(v, l), step(number)));
    };
    if (none(either(either(gain_of(5), gain_of(6)), either(gain_of(7), gain_of(8))))) return;
    const auto walk = [&](int number) HWY_ATTR {
      const int heading = heading_before(kDirection, number), l = kHeadings + heading;
      const Cells v =
          chain<way>(layer(l), where_free<kOpen>(step(number), floor_, slot(number)), load(beyond_.cost[l]));
      put(l, v);
      put(heading, plus(v, motions_.mode_change));
    };
    walk(5), walk(6), walk(7), walk(8);
  }

  HWY_INLINE void put(int l, Cells v) {
    const Cells old = layer(l);
    v = least(old, v);
    const Cells news = changed(v, old);
    news_ = least(news_, news);
    // The sideway layers that face across the row take part in its chains both ways.
    if (l == kHeadings + 2 || l == kHeadings + 6) news_of_both_ = least(news_of_both_, news);
    store(v, here_.cost[l]);
  }

  const MotionLanes& motions_;
  const FloorChunk& floor_;
  CostChunk& here_;
  const CostChunk& beyond_;
  Cells price_, news_, news_of_both_;
};

}  // namespace
}  // namespace headway::nav::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
