// Where bricks go that leave the map's window, and come from when they return to it.
#pragma once

#include <span>

#include "nav/brick.h"

namespace headway::nav {

class BrickStore {
 public:
  virtual ~BrickStore() = default;

  /// Takes a brick of which something is known, in place of an older one with this key.
  virtual void keep(const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values,
                    const BrickSummary& summary) = 0;
  /// Copies the brick with this key and returns true; leaves all as it is without one.
  virtual bool give_back(const BrickKey& key, std::span<LogOdds, kBrickVoxels> values,
                         BrickSummary& summary) = 0;
};

}  // namespace headway::nav
