#include "nav/octree_stream.h"

#include <algorithm>
#include <bit>
#include <ostream>

namespace headway::nav {

OctreeStream::Cube OctreeStream::Cube::child(int i) const {
  const int half = edge / 2;
  return {key + half * VoxelMap::Index(i & 1, i >> 1 & 1, i >> 2 & 1), half};
}

OctreeStream::OctreeStream(const VoxelMap& map, Values values)
    : map_(map),
      values_(values),
      first_key_(map.first_key() + VoxelMap::Index::Constant(kRootEdge / 2)),
      end_key_(first_key_ + map.size()),
      bricks_(map.brick_count()) {
  constexpr int kEdge = VoxelMap::kBrickEdge;
  for (std::size_t b = 0; b < bricks_.size(); ++b) {
    if (map.summary(b).unseen < VoxelMap::kBrickVoxels) {
      bricks_[b] = merged({first_key_ + kEdge * map.brick_at(b), kEdge});
    }
  }
}

OctreeStream::Node OctreeStream::voxel(const VoxelMap::Index& key) const {
  const LogOdds value = map_.value(key - first_key_);
  if (value == log_odds::kUnseen) return {};
  if (values_ == Values::kLogOdds) return {true, true, value};
  return {true, true, voxel_of(value) == Voxel::kOccupied ? log_odds::kHighest : log_odds::kLowest};
}

OctreeStream::Node OctreeStream::node(const Cube& cube) const {
  const bool outside = (cube.key.array() >= end_key_.array()).any() ||
                       (cube.key.array() + cube.edge <= first_key_.array()).any();
  if (outside) return {};
  if (cube.edge == 1) return voxel(cube.key);
  if (cube.edge == VoxelMap::kBrickEdge) {
    return bricks_[map_.brick_index((cube.key - first_key_) / VoxelMap::kBrickEdge)];
  }
  return merged(cube);
}

std::array<OctreeStream::Node, 8> OctreeStream::children(const Cube& cube) const {
  std::array<Node, 8> nodes;
  for (int i = 0; i < 8; ++i) nodes[static_cast<std::size_t>(i)] = node(cube.child(i));
  return nodes;
}

OctreeStream::Node OctreeStream::merged(const Cube& cube) const {
  const std::array<Node, 8> nodes = children(cube);
  Node all{false, true, log_odds::kUnseen};
  for (const Node& n : nodes) {
    all.known |= n.known;
    all.leaf &= n.leaf && n.value == nodes[0].value;
    all.value = std::max(all.value, n.value);
  }
  return all;
}

std::size_t OctreeStream::size() const {
  const Cube root{VoxelMap::Index::Zero(), kRootEdge};
  return node(root).known ? 1 + count_below(root) : 0;
}

std::size_t OctreeStream::count_below(const Cube& cube) const {
  const std::array<Node, 8> nodes = children(cube);
  std::size_t count = 0;
  for (int i = 0; i < 8; ++i) {
    const Node& n = nodes[static_cast<std::size_t>(i)];
    if (n.known) count += n.leaf ? 1 : 1 + count_below(cube.child(i));
  }
  return count;
}

void OctreeStream::write_bits(std::ostream& out) const {
  const Cube root{VoxelMap::Index::Zero(), kRootEdge};
  if (node(root).known) write_bits(out, root);
}

// Two bits per child, the lower first: 00 unseen, 10 empty leaf, 01 occupied leaf, 11 inner node.
void OctreeStream::write_bits(std::ostream& out, const Cube& cube) const {
  const std::array<Node, 8> nodes = children(cube);
  unsigned bits = 0;
  for (unsigned i = 0; i < 8; ++i) {
    const Node& n = nodes[i];
    const unsigned code = !n.known ? 0U : !n.leaf ? 3U : voxel_of(n.value) == Voxel::kOccupied ? 2U : 1U;
    bits |= code << (2 * i);
  }
  out.put(static_cast<char>(bits & 255));
  out.put(static_cast<char>(bits >> 8));
  for (int i = 0; i < 8; ++i) {
    const Node& n = nodes[static_cast<std::size_t>(i)];
    if (n.known && !n.leaf) write_bits(out, cube.child(i));
  }
}

void OctreeStream::write_log_odds(std::ostream& out) const {
  const Cube root{VoxelMap::Index::Zero(), kRootEdge};
  const Node all = node(root);
  if (all.known) write_log_odds(out, root, all);
}

void OctreeStream::write_log_odds(std::ostream& out, const Cube& cube, const Node& self) const {
  const auto value = std::bit_cast<std::uint32_t>(static_cast<float>(self.value * log_odds::kUnit));
  for (unsigned shift = 0; shift < 32; shift += 8) out.put(static_cast<char>(value >> shift & 255));
  if (self.leaf) {
    out.put(0);
    return;
  }
  const std::array<Node, 8> nodes = children(cube);
  unsigned present = 0;
  for (unsigned i = 0; i < 8; ++i) present |= static_cast<unsigned>(nodes[i].known) << i;
  out.put(static_cast<char>(present));
  for (int i = 0; i < 8; ++i) {
    const Node& n = nodes[static_cast<std::size_t>(i)];
    if (n.known) write_log_odds(out, cube.child(i), n);
  }
}

}  // namespace headway::nav
