#include "nav/octomap_files.h"

#include <ostream>

#include "nav/octree_stream.h"
#include "nav/whole_file.h"

namespace headway::nav {
namespace {

constexpr int kKeyOfOrigin = 32768;

octomap::OcTreeKey key_of(const VoxelMap& map, const VoxelMap::Index& voxel) {
  const VoxelMap::Index key = voxel + map.first_key() + VoxelMap::Index::Constant(kKeyOfOrigin);
  return {static_cast<octomap::key_type>(key.x()), static_cast<octomap::key_type>(key.y()),
          static_cast<octomap::key_type>(key.z())};
}

void add_brick(const VoxelMap& map, std::size_t brick, octomap::OcTree& tree) {
  constexpr int kEdge = VoxelMap::kBrickEdge;
  const VoxelMap::Index first = kEdge * map.brick_at(brick);
  const auto values = map.values(brick);
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      for (int x = 0; x < kEdge; ++x) {
        const LogOdds value = values[static_cast<std::size_t>(VoxelMap::in_brick(x, y, z))];
        if (value == log_odds::kUnseen) continue;
        constexpr bool kInnerNodesLater = true;
        tree.setNodeValue(key_of(map, first + VoxelMap::Index(x, y, z)),
                          static_cast<float>(value * log_odds::kUnit), kInnerNodesLater);
      }
    }
  }
}

void write_header(std::ostream& out, const char* magic, std::size_t nodes, double resolution) {
  out << magic << "\n#\nid OcTree\nsize " << nodes << "\nres " << resolution << "\ndata\n";
}

}  // namespace

std::unique_ptr<octomap::OcTree> to_octree(const VoxelMap& map) {
  auto tree = std::make_unique<octomap::OcTree>(map.resolution());
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    if (map.summary(b).unseen < VoxelMap::kBrickVoxels) add_brick(map, b, *tree);
  }
  tree->updateInnerOccupancy();
  tree->prune();
  return tree;
}

void write_bt(const VoxelMap& map, const std::filesystem::path& file) {
  const OctreeStream tree(map, OctreeStream::Values::kOccupiedOrEmpty);
  write_whole(file, [&](std::ostream& out) {
    write_header(out, "# Octomap OcTree binary file", tree.size(), map.resolution());
    tree.write_bits(out);
  });
}

void write_ot(const VoxelMap& map, const std::filesystem::path& file) {
  const OctreeStream tree(map, OctreeStream::Values::kLogOdds);
  write_whole(file, [&](std::ostream& out) {
    write_header(out, "# Octomap OcTree file", tree.size(), map.resolution());
    tree.write_log_odds(out);
  });
}

}  // namespace headway::nav
