// A store of bricks as simple as can be, for tests.
#pragma once

#include <algorithm>
#include <map>

#include "nav/brick_store.h"

namespace headway::nav {

class Attic final : public BrickStore {
 public:
  void keep(const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values,
            const BrickSummary& summary) override {
    Brick& brick = bricks[key];
    std::ranges::copy(values, brick.values.begin());
    brick.summary = summary;
  }
  bool give_back(const BrickKey& key, std::span<LogOdds, kBrickVoxels> values,
                 BrickSummary& summary) override {
    const auto found = bricks.find(key);
    if (found == bricks.end()) return false;
    std::ranges::copy(found->second.values, values.begin());
    summary = found->second.summary;
    return true;
  }
  std::map<BrickKey, Brick> bricks;
};

}  // namespace headway::nav
