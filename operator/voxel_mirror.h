// All bricks that were ever told, so that each viewer gets what has changed since it asked last, however slow
// it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "operator/messages.h"
#include "operator/seen.h"

namespace headway::remote {

class VoxelMirror {
 public:
  static constexpr std::size_t kAtOnce = 2000;  ///< bricks of a message

  void take(const SeenBrick& brick);
  /// What has changed since `version`, the oldest first; `version` moves on to the newest of it. From 0 on,
  /// or from another world, everything: `whole` tells the viewer to forget what it knew. False when nothing
  /// has changed.
  bool since(std::uint64_t& version, Voxels& out) const;
  std::size_t bricks() const { return by_version_.size(); }

 private:
  std::uint64_t newest_ = 0, begun_ = 0;  ///< versions: the newest, and that from which on this world counts
  std::uint32_t world_ = 0;
  std::map<nav::BrickKey, std::uint64_t> version_of_;
  std::map<std::uint64_t, SeenBrick> by_version_;
};

}  // namespace headway::remote
