// The voxel map as the nodes of a pruned octree, in the order and the bytes of OctoMap's files.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <vector>

#include "nav/voxel_map.h"

namespace headway::nav {

/// Walks the tree that the map would be, without building it.
class OctreeStream {
 public:
  enum class Values : std::uint8_t {
    kOccupiedOrEmpty,  ///< .bt: only which of both is likelier
    kLogOdds,          ///< .ot
  };
  OctreeStream(const VoxelMap& map, Values values);

  /// Nodes, inner ones too.
  std::size_t size() const;
  /// The data section of a .bt file: two bits per child, two bytes per inner node.
  void write_bits(std::ostream& out) const;
  /// The data section of a .ot file: log-odds and a byte of children per node.
  void write_log_odds(std::ostream& out) const;

 private:
  /// What a cube of the tree holds.
  struct Node {
    bool known = false;
    bool leaf = false;                  ///< known throughout, with one value
    LogOdds value = log_odds::kUnseen;  ///< the largest in it, as OctoMap's inner nodes
  };
  /// A cube of voxels, placed by OctoMap's keys.
  struct Cube {
    VoxelMap::Index key;
    int edge;
    Cube child(int i) const;
  };
  static constexpr int kRootEdge = 65536;

  Node node(const Cube& cube) const;
  Node merged(const Cube& cube) const;
  Node voxel(const VoxelMap::Index& key) const;
  std::array<Node, 8> children(const Cube& cube) const;
  std::size_t count_below(const Cube& cube) const;
  void write_bits(std::ostream& out, const Cube& cube) const;
  void write_log_odds(std::ostream& out, const Cube& cube, const Node& node) const;

  const VoxelMap& map_;
  Values values_;
  VoxelMap::Index first_key_, end_key_;  ///< of the map's box
  std::vector<Node> bricks_;
};

}  // namespace headway::nav
