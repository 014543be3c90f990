#include "nav/octomap_files.h"

#include <bit>
#include <cmath>
#include <ostream>
#include <sstream>

#include <fmt/format.h>

#include "hal/error.h"
#include "nav/byte_reader.h"
#include "nav/octree_leaves.h"
#include "nav/octree_stream.h"
#include "nav/whole_file.h"

namespace headway::nav {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBtMagic = "# Octomap OcTree binary file";
constexpr const char* kOtMagic = "# Octomap OcTree file";
constexpr int kMostHeaderLines = 1000;

void write_tree(const char* magic, double resolution, const OctreeData& tree, std::ostream& out) {
  out << magic << "\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
      << fmt::format("id OcTree\nsize {}\nres {}\ndata\n", tree.nodes, resolution);
  out.write(tree.bytes.data(), static_cast<std::streamsize>(tree.bytes.size()));
}

struct Header {
  double resolution = 0;
  std::uint64_t nodes = 0;
};

/// Lines of a key and a value each, after the magic one, up to "data".
Header read_header(ByteReader& in, const std::string& magic) {
  Header header;
  if (in.at_end() || in.line() != magic) in.fail("expected '" + magic + "' in the first line");
  std::string id, size, res;
  for (int n = 0; n < kMostHeaderLines; ++n) {
    const std::string line = in.line();
    if (line.empty() || line.starts_with('#')) continue;
    const std::string key = line.substr(0, line.find(' '));
    const std::string value = key.size() < line.size() ? line.substr(key.size() + 1) : "";
    if (key == "id") {
      id = value;
    } else if (key == "size") {
      size = value;
    } else if (key == "res") {
      res = value;
    } else if (key == "data") {
      if (id != "OcTree") in.fail("id: '" + id + "', expected OcTree; other kinds of tree are not read");
      if (!parse_number(size, header.nodes)) in.fail("size: '" + size + "', expected the number of nodes");
      if (!parse_number(res, header.resolution) || !(header.resolution >= ColdMap::kFinest) ||
          !(header.resolution <= ColdMap::kCoarsest)) {
        in.fail(fmt::format("res: '{}', expected {} to {} m", res, ColdMap::kFinest, ColdMap::kCoarsest));
      }
      return header;
    }
  }
  in.fail("the header does not end; expected a line 'data'");
}

/// What .bt and .ot have in common: a header, and nodes depth first, each a child of one before.
class TreeReader {
 public:
  TreeReader(ByteReader& in, const char* magic, const std::string& file, std::size_t most_bricks)
      : in_(in), header_(read_header(in, magic)), leaves_(header_.resolution, file, most_bricks) {}

  ColdMap bits() && {
    if (header_.nodes > 0) {
      note_node();
      children_by_bits({});
    }
    return std::move(*this).finish();
  }

  ColdMap log_odds() && {
    if (header_.nodes > 0) node_with_log_odds({});
    return std::move(*this).finish();
  }

 private:
  // Two bits per child, the lower first: 00 unseen, 10 empty leaf, 01 occupied leaf, 11 inner node.
  void children_by_bits(const OctreeCube& cube) {
    const unsigned low = in_.byte(), word = low | static_cast<unsigned>(in_.byte()) << 8;
    for (unsigned i = 0; i < 8; ++i) {
      const unsigned code = word >> (2 * i) & 3;
      if (code == 0) continue;
      const OctreeCube child = cube.child(i);
      note_node();
      if (code == 1) leaves_.add(child, log_odds::kLowest);
      if (code == 2) leaves_.add(child, log_odds::kHighest);
      if (code == 3) children_by_bits(inner(child));
    }
  }

  void node_with_log_odds(const OctreeCube& cube) {
    note_node();
    const auto value = static_cast<double>(std::bit_cast<float>(in_.word()));
    if (!std::isfinite(value)) in_.fail(fmt::format("log-odds of node {} are no number", nodes_));
    const unsigned children = in_.byte();
    if (children == 0) return leaves_.add(cube, units_of(value, value >= 0));
    inner(cube);
    for (unsigned i = 0; i < 8; ++i) {
      if ((children >> i & 1) != 0) node_with_log_odds(cube.child(i));
    }
  }

  /// A node that has children: never a voxel, so a chain of nodes ends.
  const OctreeCube& inner(const OctreeCube& cube) const {
    if (cube.edge == 1) in_.fail(fmt::format("node {} lies below the 16th level", nodes_));
    return cube;
  }

  void note_node() {
    if (++nodes_ > header_.nodes)
      in_.fail(fmt::format("holds more than the {} nodes it claims", header_.nodes));
  }

  ColdMap finish() && {
    if (nodes_ != header_.nodes)
      in_.fail(fmt::format("holds {} nodes, but claims {}", nodes_, header_.nodes));
    return std::move(leaves_).take();
  }

  ByteReader& in_;
  Header header_;
  OctreeLeaves leaves_;
  std::uint64_t nodes_ = 0;
};

}  // namespace

std::unique_ptr<octomap::OcTree> to_octree(const SeenBricks& map) {
  auto tree = std::make_unique<octomap::OcTree>(map.resolution());
  OctreeData data = octree_log_odds(map);
  std::istringstream nodes(std::move(data.bytes));
  if (data.nodes > 0) tree->readData(nodes);
  return tree;
}

ColdMap from_octree(const octomap::OcTree& tree, std::size_t most_bricks) {
  OctreeLeaves leaves(tree.getResolution(), "octree", most_bricks);
  for (auto leaf = tree.begin_leafs(), end = tree.end_leafs(); leaf != end; ++leaf) {
    const octomap::OcTreeKey key = leaf.getIndexKey();
    const auto value = static_cast<double>(leaf->getLogOdds());
    if (!std::isfinite(value)) throw InputError("octree: a leaf's log-odds are no number");
    leaves.add({key[0], key[1], key[2], 1 << (tree.getTreeDepth() - leaf.getDepth())},
               units_of(value, tree.isNodeOccupied(*leaf)));
  }
  return std::move(leaves).take();
}

void write_bt(const SeenBricks& map, std::ostream& out) {
  write_tree(kBtMagic, map.resolution(), octree_bits(map), out);
}

void write_ot(const SeenBricks& map, std::ostream& out) {
  write_tree(kOtMagic, map.resolution(), octree_log_odds(map), out);
}

void write_bt(const SeenBricks& map, const fs::path& file) {
  write_whole(file, [&](std::ostream& out) { write_bt(map, out); });
}

void write_ot(const SeenBricks& map, const fs::path& file) {
  write_whole(file, [&](std::ostream& out) { write_ot(map, out); });
}

ColdMap read_bt(std::istream& in, const std::string& file, std::size_t most_bricks) {
  ByteReader bytes(in, file);
  return TreeReader(bytes, kBtMagic, file, most_bricks).bits();
}

ColdMap read_ot(std::istream& in, const std::string& file, std::size_t most_bricks) {
  ByteReader bytes(in, file);
  return TreeReader(bytes, kOtMagic, file, most_bricks).log_odds();
}

ColdMap read_bt(const fs::path& file, std::size_t most_bricks) {
  std::ifstream in = open_whole(file);
  return read_bt(in, file.string(), most_bricks);
}

ColdMap read_ot(const fs::path& file, std::size_t most_bricks) {
  std::ifstream in = open_whole(file);
  return read_ot(in, file.string(), most_bricks);
}

}  // namespace headway::nav
