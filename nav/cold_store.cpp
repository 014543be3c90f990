#include "nav/cold_store.h"

#include <algorithm>

namespace headway::nav {

void ColdStore::keep(const BrickKey& key, std::span<const LogOdds, kBrickVoxels> values,
                     const BrickSummary&) {
  map_.put(key, values);  // the window keeps within OctoMap's trees
}

bool ColdStore::give_back(const BrickKey& key, std::span<LogOdds, kBrickVoxels> values,
                          BrickSummary& summary) {
  BrickValues kept;
  if (!map_.take(key, kept)) return false;
  std::ranges::copy(kept, values.begin());
  const auto is_occupied = [](LogOdds value) { return value >= log_odds::kOccupied; };
  summary = {static_cast<std::uint16_t>(std::ranges::count(kept, log_odds::kUnseen)),
             static_cast<std::uint16_t>(std::ranges::count_if(kept, is_occupied)), kNever};
  return true;
}

}  // namespace headway::nav
