// Maps as OctoMap's files and trees, for every tool that reads those.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>

#include <octomap/OcTree.h>

#include "nav/cold_map.h"
#include "nav/seen_bricks.h"

namespace headway::nav {

/// The same map as an OctoMap tree: empty and occupied voxels as leaves of depth 16 with their log-odds
/// (pruned); unseen ones are absent.
std::unique_ptr<octomap::OcTree> to_octree(const SeenBricks& map);
/// The map of a tree. Log-odds go to the nearest unit within log_odds::kLowest..kHighest, and every leaf
/// stays what the tree says: occupied or empty. Throws InputError when it holds more bricks than
/// `most_bricks` (a leaf above voxels stands for many) or log-odds that are no number.
ColdMap from_octree(const octomap::OcTree& tree, std::size_t most_bricks = kMostBricks);

/// Binary tree, occupied or empty only, straight from the bricks. The file appears whole or not at all.
/// Throws as write_whole does.
void write_bt(const SeenBricks& map, const std::filesystem::path& file);
/// Full tree with log-odds. As write_bt.
void write_ot(const SeenBricks& map, const std::filesystem::path& file);
void write_bt(const SeenBricks& map, std::ostream& out);
void write_ot(const SeenBricks& map, std::ostream& out);

/// Reads a .bt file of OctoMap's; occupied voxels count as seen often (log_odds::kHighest), empty ones too
/// (kLowest), as in OctoMap. Throws InputError `file: what` on anything malformed, and when it holds more
/// bricks than `most_bricks`.
ColdMap read_bt(const std::filesystem::path& file, std::size_t most_bricks = kMostBricks);
/// Reads a .ot file with a tree of type OcTree. Values as from_octree, errors as read_bt.
ColdMap read_ot(const std::filesystem::path& file, std::size_t most_bricks = kMostBricks);
/// The same from a stream; `file` is only named in complaints.
ColdMap read_bt(std::istream& in, const std::string& file, std::size_t most_bricks = kMostBricks);
ColdMap read_ot(std::istream& in, const std::string& file, std::size_t most_bricks = kMostBricks);

}  // namespace headway::nav
