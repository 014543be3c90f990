// Random maps of bricks for properties: single voxels, boxes that fill bricks, and bricks far apart.
#pragma once

#include <algorithm>
#include <array>

#include <rapidcheck.h>

#include "nav/cold_map.h"

namespace headway::nav {

inline LogOdds any_log_odds() {
  return static_cast<LogOdds>(*rc::gen::inRange<int>(log_odds::kLowest, log_odds::kHighest + 1));
}

/// A brick with up to three boxes of one value each; may hold nothing.
inline BrickValues any_brick() {
  BrickValues values;
  values.fill(log_odds::kUnseen);
  const int boxes = *rc::gen::inRange(0, 4);
  for (int b = 0; b < boxes; ++b) {
    const LogOdds value = any_log_odds();
    std::array<int, 3> low{}, high{};
    for (std::size_t k = 0; k < 3; ++k) {  // whole halves and quarters too, so that nodes are pruned
      low[k] = *rc::gen::element(0, 0, 2, 4, 6, *rc::gen::inRange(0, kBrickEdge));
      high[k] = *rc::gen::element(low[k] + 1, std::min(low[k] + 2, kBrickEdge), kBrickEdge, kBrickEdge);
    }
    for (int z = low[2]; z < high[2]; ++z) {
      for (int y = low[1]; y < high[1]; ++y) {
        for (int x = low[0]; x < high[0]; ++x) values[static_cast<std::size_t>(in_brick(x, y, z))] = value;
      }
    }
  }
  return values;
}

/// Near the origin, where bricks meet, or anywhere in the tree, its ends among them.
inline BrickKey any_key() {
  const auto along = [] {
    return *rc::gen::oneOf(rc::gen::inRange(-3, 4), rc::gen::inRange(-kBrickReach, kBrickReach),
                           rc::gen::element(-kBrickReach, kBrickReach - 1));
  };
  return {along(), along(), along()};
}

inline ColdMap any_cold_map() {
  ColdMap map(*rc::gen::element(0.05, 0.02, 0.1, 0.0625, 0.0123456789));
  const int bricks = *rc::gen::inRange(0, 12);
  for (int b = 0; b < bricks; ++b) map.put(any_key(), any_brick());
  if (*rc::gen::arbitrary<bool>()) {  // a block of bricks of one value: leaves above bricks
    const LogOdds value = any_log_odds();
    const int edge = *rc::gen::element(2, 4), from = *rc::gen::element(-4, 0, 1);
    for (int i = 0; i < edge * edge * edge; ++i) {
      BrickValues full;
      full.fill(value);
      map.put({from + i % edge, from + i / edge % edge, from + i / edge / edge}, full);
    }
  }
  return map;
}

/// What is left of a map when only occupied or empty is kept, as in .bt files.
inline ColdMap occupied_or_empty(const ColdMap& map) {
  ColdMap kept(map.resolution());
  map.for_any([&](const BrickKey& key, BrickValues values) {
    for (LogOdds& v : values) {
      if (v != log_odds::kUnseen) v = v >= log_odds::kOccupied ? log_odds::kHighest : log_odds::kLowest;
    }
    kept.put(key, values);
  });
  return kept;
}

}  // namespace headway::nav
