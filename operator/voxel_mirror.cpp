#include "operator/voxel_mirror.h"

namespace headway::remote {

void VoxelMirror::take(const SeenBrick& brick) {
  if (brick.world != world_) {
    world_ = brick.world;
    by_version_.clear();
    version_of_.clear();
    begun_ = ++newest_;
  }
  std::uint64_t& version = version_of_[brick.key];
  by_version_.erase(version);
  version = ++newest_;
  by_version_.emplace_hint(by_version_.end(), version, brick);
}

bool VoxelMirror::since(std::uint64_t& version, Voxels& out) const {
  out.whole = version == 0 || version < begun_;
  out.keys.clear();
  out.occupied.clear();
  out.unseen.clear();
  std::size_t count = 0;
  for (auto at = by_version_.upper_bound(version); at != by_version_.end() && count < kAtOnce;
       ++at, ++count) {
    const SeenBrick& brick = at->second;
    out.keys.insert(out.keys.end(), {brick.key.x, brick.key.y, brick.key.z});
    out.occupied.insert(out.occupied.end(), brick.occupied.begin(), brick.occupied.end());
    out.unseen.insert(out.unseen.end(), brick.unseen.begin(), brick.unseen.end());
    version = at->first;
  }
  return count > 0;
}

}  // namespace headway::remote
