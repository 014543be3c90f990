#include "nav/octree_stream.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "nav/little_endian.h"

namespace headway::nav {
namespace {

using Bricks = std::span<const PlacedBrick>;
using Values = const LogOdds*;

/// The part of sorted bricks that lies in child i of a node `level` levels above them; `bricks` begins with
/// it.
Bricks in_child(Bricks bricks, int level, unsigned i) {
  const auto child = [level](const PlacedBrick& b) { return b.order >> (3 * (level - 1)) & 7; };
  const auto end =
      std::partition_point(bricks.begin(), bricks.end(), [&](const PlacedBrick& b) { return child(b) <= i; });
  return bricks.first(static_cast<std::size_t>(end - bricks.begin()));
}

/// Writes what lies `level` levels above bricks, a node before its children. A node is written with room for
/// what its children say of themselves, and taken back when they turn out to be one leaf.
template <class Nodes>
typename Nodes::Node write_cube(Nodes& nodes, Bricks bricks, int level) {
  if (bricks.empty()) return {};
  if (level == 0) return nodes.brick(bricks.front().values.data());
  const std::size_t place = nodes.open();
  std::array<typename Nodes::Node, 8> children{};
  for (unsigned i = 0; i < 8 && !bricks.empty(); ++i) {
    const Bricks part = in_child(bricks, level, i);
    children[i] = write_cube(nodes, part, level - 1);
    bricks = bricks.subspan(part.size());
  }
  return nodes.close(place, children);
}

/// Nodes of a .bt file. A node is what its parent writes of it, and only an inner one has bytes of its own.
class BitNodes {
 public:
  enum Node : std::uint8_t { kUnseen = 0, kEmpty = 1, kOccupied = 2, kInner = 3 };

  std::size_t open() {
    bytes_.append(2, '\0');
    return bytes_.size() - 2;
  }

  Node close(std::size_t place, const std::array<Node, 8>& children) {
    unsigned word = 0;
    for (unsigned i = 0; i < 8; ++i) word |= static_cast<unsigned>(children[i]) << (2 * i);
    const Node self = node_of(word);
    if (self != kInner) {
      bytes_.resize(place);
      return self;
    }
    count(word);
    put(bytes_.data() + place, word);
    return self;
  }

  Node brick(Values values) {
    std::array<std::uint16_t, 64> pairs;  // cubes of two voxels along the edge, in the tree's order
    std::array<std::uint16_t, 8> fours{};
    unsigned word = 0;
    for (unsigned four = 0; four < 8; ++four) {
      pairs_of(values + 64 * four, pairs.data() + 8 * four);
      for (unsigned i = 0; i < 8; ++i) {
        fours[four] = static_cast<std::uint16_t>(fours[four] | node_of(pairs[8 * four + i]) << (2 * i));
      }
      word |= static_cast<unsigned>(node_of(fours[four])) << (2 * four);
    }
    const Node self = node_of(word);
    if (self == kInner) write_brick(word, fours, pairs);
    return self;
  }

  OctreeData data(Node root) && { return {std::move(bytes_), root == kUnseen ? 0 : children_ + 1}; }

 private:
  /// The node with these children, two bits each.
  static Node node_of(unsigned word) {
    return word == 0 ? kUnseen : word == 0x5555 ? kEmpty : word == 0xAAAA ? kOccupied : kInner;
  }

  static void put(char* place, unsigned word) {
    place[0] = static_cast<char>(word & 255);
    place[1] = static_cast<char>(word >> 8);
  }

  void count(unsigned word) {
    children_ += static_cast<std::size_t>(std::popcount((word | word >> 1) & 0x5555U));
  }

  /// Two bits per voxel for the eight cubes of 2x2x2 voxels in 4x4x4 values, eight values at a time.
  static void pairs_of(Values values, std::uint16_t* pairs) {
    static_assert(std::endian::native == std::endian::little && in_brick(3, 1, 0) == 7 &&
                      in_brick(0, 0, 1) == 16 && in_brick(4, 0, 0) == 64,
                  "expects eight values in a word, x in its bytes, y in its halves");
    for (unsigned z = 0; z < 4; z += 2) {
      for (unsigned y = 0; y < 4; y += 2) {
        // Bytes 0 and 2: the lower four bits are x, x + 1 at y, the upper four the same at y + 1.
        const std::uint64_t low = two_rows(values + 16 * z + 4 * y);
        const std::uint64_t high = two_rows(values + 16 * z + 16 + 4 * y);
        const std::uint64_t both = low | high << 8;
        std::uint16_t* pair = pairs + 2 * z + y;
        pair[0] = static_cast<std::uint16_t>(both);
        pair[1] = static_cast<std::uint16_t>(both >> 16);
      }
    }
  }

  static std::uint64_t two_rows(Values values) {
    constexpr std::uint64_t kOnes = 0x0101010101010101U;
    std::uint64_t v;
    std::memcpy(&v, values, sizeof v);
    const std::uint64_t negative = v >> 7 & kOnes;
    const std::uint64_t rest = v & (0x7F * kOnes);
    const std::uint64_t known = ((rest + 0x7F * kOnes) >> 7 & kOnes) | (negative ^ kOnes);  // not -128
    const std::uint64_t codes = (negative & known) | (negative ^ kOnes) << 1;
    const std::uint64_t along_x = (codes | codes >> 6) & 0x000F000F000F000FU;
    return (along_x | along_x >> 28) & 0x00FF00FFU;
  }

  void write_brick(unsigned word, const std::array<std::uint16_t, 8>& fours,
                   const std::array<std::uint16_t, 64>& pairs) {
    std::array<char, std::size_t{2} * (1 + 8 + 64)> buffer;
    char* end = buffer.data();
    const auto add = [&](unsigned w) {
      put(end, w);
      end += 2;
      count(w);
    };
    add(word);
    for (unsigned four = 0; four < 8; ++four) {
      if (node_of(fours[four]) != kInner) continue;
      add(fours[four]);
      for (unsigned i = 0; i < 8; ++i) {
        if (node_of(pairs[8 * four + i]) == kInner) add(pairs[8 * four + i]);
      }
    }
    bytes_.append(buffer.data(), static_cast<std::size_t>(end - buffer.data()));
  }

  std::string bytes_;
  std::size_t children_ = 0;
};

/// Nodes of a .ot file, five bytes each.
class LogOddsNodes {
 public:
  struct Node {
    bool leaf = false;                  ///< known throughout, with one value
    LogOdds value = log_odds::kUnseen;  ///< the largest in it, as OctoMap's inner nodes
    bool known() const { return value != log_odds::kUnseen; }
  };

  std::size_t open() {
    bytes_.append(kBytes, '\0');
    return bytes_.size() - kBytes;
  }

  Node close(std::size_t place, const std::array<Node, 8>& children) {
    Node self{true, log_odds::kUnseen};
    unsigned present = 0;
    for (unsigned i = 0; i < 8; ++i) {
      present |= static_cast<unsigned>(children[i].known()) << i;
      self.leaf &= children[i].leaf && children[i].value == children[0].value;
      self.value = std::max(self.value, children[i].value);
    }
    if (!self.known() || self.leaf) bytes_.resize(place);
    if (self.leaf) return leaf(self.value);
    if (self.known()) put(place, self.value, present);
    return self;
  }

  Node brick(Values values) { return cube(values, kBrickEdge, 0, 0, 0); }

  OctreeData data(Node) && {
    const std::size_t nodes = bytes_.size() / kBytes;
    return {std::move(bytes_), nodes};
  }

 private:
  static constexpr std::size_t kBytes = 5;

  Node leaf(LogOdds value) {
    if (value != log_odds::kUnseen) put(open(), value, 0);
    return {value != log_odds::kUnseen, value};
  }

  Node cube(Values values, int edge, int x, int y, int z) {
    if (edge == 1) return leaf(values[in_brick(x, y, z)]);
    const std::size_t place = open();
    std::array<Node, 8> children;
    const int half = edge / 2;
    for (int i = 0; i < 8; ++i) {
      children[static_cast<std::size_t>(i)] =
          cube(values, half, x + half * (i & 1), y + half * (i >> 1 & 1), z + half * (i >> 2));
    }
    return close(place, children);
  }

  void put(std::size_t place, LogOdds value, unsigned children) {
    const auto bytes = little_endian(static_cast<float>(value * log_odds::kUnit));
    bytes_.replace(place, 4, bytes.text());
    bytes_[place + 4] = static_cast<char>(children);
  }

  std::string bytes_;
};

template <class Nodes>
OctreeData write_tree(const SeenBricks& map) {
  Nodes nodes;
  const auto root = write_cube(nodes, map.bricks(), kLevelsAboveBrick);
  return std::move(nodes).data(root);
}

}  // namespace

OctreeData octree_bits(const SeenBricks& map) { return write_tree<BitNodes>(map); }

OctreeData octree_log_odds(const SeenBricks& map) { return write_tree<LogOddsNodes>(map); }

}  // namespace headway::nav
