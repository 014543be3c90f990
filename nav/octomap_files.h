// The voxel map as OctoMap's files, for every tool that reads those.
#pragma once

#include <filesystem>
#include <memory>

#include <octomap/OcTree.h>

#include "nav/voxel_map.h"

namespace headway::nav {

/// The same map as an OctoMap tree: empty and occupied voxels as leaves of depth 16 with their log-odds
/// (pruned); unseen ones are absent.
std::unique_ptr<octomap::OcTree> to_octree(const VoxelMap& map);

/// Binary tree, occupied or empty only, straight from the bricks. The file appears whole or not at all.
/// Throws InputError when it cannot be written.
void write_bt(const VoxelMap& map, const std::filesystem::path& file);
/// Full tree with log-odds. As write_bt.
void write_ot(const VoxelMap& map, const std::filesystem::path& file);

}  // namespace headway::nav
