// The bricks of a map as the nodes of a pruned octree, in the order and the bytes of OctoMap's files, without
// building that tree.
#pragma once

#include <cstddef>
#include <string>

#include "nav/seen_bricks.h"

namespace headway::nav {

/// The data section of a file of OctoMap's.
struct OctreeData {
  std::string bytes;
  std::size_t nodes = 0;  ///< inner ones too
};

/// Of a .bt file: which voxels are occupied and which are empty; two bits per child, two bytes per inner
/// node.
OctreeData octree_bits(const SeenBricks& map);
/// Of a .ot file: log-odds (an inner node has the largest below it) and a byte of children per node.
OctreeData octree_log_odds(const SeenBricks& map);

}  // namespace headway::nav
