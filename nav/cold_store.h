// Keeps the bricks that leave the map's window in a cold map, and gives them back.
#pragma once

#include "nav/brick_store.h"
#include "nav/cold_map.h"

namespace headway::nav {

/// A brick is either in the window or here, never in both.
class ColdStore final : public BrickStore {
 public:
  /// `resolution`: edge of a voxel [m]. Throws InputError when it is none.
  explicit ColdStore(double resolution) : map_(resolution) {}

  void keep(const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values,
            const BrickSummary& summary) override;
  /// When a brick was changed is not kept: it comes back as changed before all else.
  bool give_back(const BrickKey& key, std::span<LogOdds, kBrickVoxels> values,
                 BrickSummary& summary) override;

  const ColdMap& map() const { return map_; }

 private:
  ColdMap map_;
};

}  // namespace headway::nav
