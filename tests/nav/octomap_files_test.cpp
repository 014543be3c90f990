// OctoMap's own library reads the files back and is asked for each voxel.
#include "nav/octomap_files.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "any_cold_map.h"
#include "hal/error.h"
#include "nav/integrate.h"
#include "synthetic_room.h"
#include "tests/temporary_folder.h"

namespace headway::nav {
namespace {

using Index = VoxelMap::Index;

octomap::point3d point(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// Where `read` differs from the map, as one line; empty when nowhere.
std::string difference(const VoxelMap& map, const octomap::OcTree& read, bool log_odds_too) {
  if (std::abs(read.getResolution() - map.resolution()) > 1e-9) return "resolution";
  std::size_t known = 0;
  for (int z = 0; z < map.size().z(); ++z) {
    for (int y = 0; y < map.size().y(); ++y) {
      for (int x = 0; x < map.size().x(); ++x) {
        const Index i(x, y, z);
        const octomap::OcTreeNode* node = read.search(point(map.centre(i)));
        const Voxel seen = node == nullptr             ? Voxel::kUnseen
                           : read.isNodeOccupied(node) ? Voxel::kOccupied
                                                       : Voxel::kEmpty;
        known += seen != Voxel::kUnseen;
        const std::string where = std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z);
        if (seen != map.at(i)) return "state at " + where;
        const bool same = node == nullptr || std::abs(static_cast<double>(node->getLogOdds()) -
                                                      map.value(i) * log_odds::kUnit) < 0.025;
        if (log_odds_too && !same) return "log-odds at " + where;
      }
    }
  }
  // Nothing outside of the map's box either: its voxels are all that the tree knows.
  std::size_t leaves = 0;
  for (auto leaf = read.begin_leafs(); leaf != read.end_leafs(); ++leaf) {
    const std::size_t edge = std::size_t{1} << (read.getTreeDepth() - leaf.getDepth());
    leaves += edge * edge * edge;
  }
  return leaves == known ? "" : "voxels outside";
}

std::string data_section(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  return text.substr(text.find("data\n") + 5);
}

VoxelMap any_map() {
  VoxelMapConfig config;
  config.resolution = *rc::gen::element(0.05, 0.02);
  config.lowest = Eigen::Vector3d::Constant(-8 * config.resolution);
  config.highest = Eigen::Vector3d::Constant(16 * config.resolution);
  config.lowest.x() += 0.4 * *rc::gen::inRange(-5, 5);
  config.highest.x() = config.lowest.x() + 1;
  VoxelMap map(config);
  const int boxes = *rc::gen::inRange(0, 6);  // some fill whole bricks, so that nodes are pruned
  for (int b = 0; b < boxes; ++b) {
    const auto value = static_cast<LogOdds>(*rc::gen::inRange(-40, 71));
    Index low, high;
    for (int k = 0; k < 3; ++k) {
      low[k] = *rc::gen::inRange(0, map.size()[k]);
      high[k] = *rc::gen::inRange(low[k], map.size()[k]);
    }
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          map.edit(map.brick_index(
              {x / 8, y / 8, z / 8}))[static_cast<std::size_t>(VoxelMap::in_brick(x % 8, y % 8, z % 8))] =
              value;
        }
      }
    }
  }
  for (std::size_t b = 0; b < map.brick_count(); ++b) map.settle(b, at_seconds(1));
  return map;
}

/// The tree that OctoMap's own library builds, voxel by voxel.
std::unique_ptr<octomap::OcTree> built_by_octomap(const SeenBricks& map) {
  auto tree = std::make_unique<octomap::OcTree>(map.resolution());
  for (const PlacedBrick& brick : map.bricks()) {
    const BrickKey key = brick_at(brick.order);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const LogOdds value = brick.values[static_cast<std::size_t>(i)];
      if (value == log_odds::kUnseen) continue;
      const VoxelOfBrick in = voxel_of_brick(i);
      const auto along = [](std::int32_t k, int v) {
        return static_cast<octomap::key_type>(8 * k + v + 32768);
      };
      const octomap::OcTreeKey voxel(along(key.x, in.x), along(key.y, in.y), along(key.z, in.z));
      tree->setNodeValue(voxel, static_cast<float>(value * log_odds::kUnit), true);
    }
  }
  tree->updateInnerOccupancy();
  tree->prune();
  return tree;
}

/// Compares with OctoMap node by node: as .ot, as .bt, and as a tree.
void check_against_octomap(const SeenBricks& map) {
  const TemporaryFolder folder;
  const auto tree = built_by_octomap(map);
  RC_ASSERT(*to_octree(map) == *tree);
  write_ot(map, folder / "map.ot");
  std::ostringstream data;
  if (tree->size() > 0) tree->writeData(data);
  RC_ASSERT(data_section(folder / "map.ot") == data.str());
  write_bt(map, folder / "map.bt");
  octomap::OcTree binary(1.0);
  RC_ASSERT(binary.readBinary((folder / "map.bt").string()));
  binary.updateInnerOccupancy();  // the reader leaves the root alone
  tree->expand();                 // prune() begins at the voxels, and ends where it finds nothing
  tree->toMaxLikelihood();
  tree->prune();
  RC_ASSERT(binary.size() == tree->size());
  RC_ASSERT(binary == *tree);
}

RC_GTEST_PROP(OctomapFiles, AreTheTreeThatOctomapItselfBuilds, ()) {
  const VoxelMap map = any_map();
  RC_ASSERT(difference(map, *to_octree(map), true) == "");
  check_against_octomap(map);
}

RC_GTEST_PROP(OctomapFiles, AreTheTreeThatOctomapItselfBuildsOfAColdMap, ()) {
  check_against_octomap(any_cold_map());
}

RC_GTEST_PROP(OctomapFiles, GiveBackWhatWasWritten, ()) {
  const ColdMap map = any_cold_map();
  const TemporaryFolder folder;
  write_ot(map, folder / "map.ot");
  RC_ASSERT(read_ot(folder / "map.ot") == map);
  write_bt(map, folder / "map.bt");
  RC_ASSERT(read_bt(folder / "map.bt") == occupied_or_empty(map));
}

RC_GTEST_PROP(OctomapFiles, AreReadAsOctomapWritesThem, ()) {
  const ColdMap map = any_cold_map();
  const auto tree = built_by_octomap(map);
  if (*rc::gen::arbitrary<bool>()) tree->expand();
  const TemporaryFolder folder;
  if (tree->size() == 0) return;  // OctoMap writes no tree without nodes
  RC_ASSERT(tree->write((folder / "map.ot").string()));
  RC_ASSERT(tree->writeBinaryConst((folder / "map.bt").string()));
  RC_ASSERT(std::abs(read_bt(folder / "map.bt").resolution() - map.resolution()) < 1e-6);  // six digits
  ColdMap expected(read_ot(folder / "map.ot").resolution());
  map.for_any([&](const BrickKey& key, const BrickValues& values) { expected.put(key, values); });
  RC_ASSERT(read_ot(folder / "map.ot") == expected);
  RC_ASSERT(read_bt(folder / "map.bt") == occupied_or_empty(expected));
}

RC_GTEST_PROP(Octree, OfAMapGivesTheMapBack, ()) {
  const ColdMap map = any_cold_map();
  RC_ASSERT(from_octree(*to_octree(map)) == map);
}

// Sensors of any kind: OctoMap's own ray casting with its own log-odds, which are no whole units.
RC_GTEST_PROP(Octree, SurvivesTheWayThereAndBackToHalfAUnit, ()) {
  octomap::OcTree tree(0.1);
  const double threshold = *rc::gen::element(0.5, 0.4, 0.7);
  tree.setOccupancyThres(threshold);
  tree.setProbHit(*rc::gen::element(0.7, 0.61));
  tree.setProbMiss(*rc::gen::element(0.4, 0.47));
  octomap::Pointcloud cloud;
  const auto along = [] { return static_cast<float>(0.01 * *rc::gen::inRange(-200, 200)); };
  for (int i = 0; i < 12; ++i) cloud.push_back(along(), along(), along());
  for (int i = 0; i < 3; ++i) tree.insertPointCloud(cloud, {along(), along(), along()});
  tree.prune();
  const ColdMap map = from_octree(tree);
  const auto back = to_octree(map);
  std::size_t voxels = 0, voxels_back = 0;
  const auto count = [](const octomap::OcTree& t, std::size_t& n) {
    for (auto leaf = t.begin_leafs(); leaf != t.end_leafs(); ++leaf) {
      n += std::size_t{1} << 3 * (16 - leaf.getDepth());
    }
  };
  count(tree, voxels);
  count(*back, voxels_back);
  RC_ASSERT(voxels == voxels_back);
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const auto* node = back->search(leaf.getKey());
    RC_ASSERT(node != nullptr);
    RC_ASSERT(back->isNodeOccupied(node) == tree.isNodeOccupied(*leaf));
    const auto value = static_cast<double>(node->getLogOdds());
    const bool near = std::abs(value - static_cast<double>(leaf->getLogOdds())) <= log_odds::kUnit / 2 + 1e-6;
    const bool on_the_edge = value == 0 || std::abs(value + log_odds::kUnit) < 1e-6;  // to stay on its side
    RC_ASSERT(near || on_the_edge);
  }
}

// OctoMap's own example: a corridor and its rooms, mapped by a laser scanner.
std::filesystem::path geb079() { return "/usr/share/doc/liboctomap-dev/examples/data/geb079.bt"; }

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(OctomapFiles, HoldTheSameBytesAfterARealFileIsReadAndWritten) {
  if (!std::filesystem::exists(geb079())) GTEST_SKIP() << geb079() << " is missing (liboctomap-dev)";
  const ColdMap map = read_bt(geb079());
  EXPECT_EQ(map.resolution(), 0.08);
  const TemporaryFolder folder;
  write_bt(map, folder / "again.bt");
  EXPECT_TRUE(contents(folder / "again.bt") == contents(geb079()));
  octomap::OcTree theirs(1.0), ours(1.0);
  ASSERT_TRUE(theirs.readBinary(geb079().string()) && ours.readBinary((folder / "again.bt").string()));
  EXPECT_TRUE(ours == theirs);
  EXPECT_TRUE(from_octree(theirs) == map);
}

RC_GTEST_PROP(OctomapFiles, HoldTheMapNodeByNode, ()) {
  const VoxelMap map = any_map();
  const TemporaryFolder folder;
  write_bt(map, folder / "map.bt");
  write_ot(map, folder / "map.ot");
  octomap::OcTree binary(1.0);
  RC_ASSERT(binary.readBinary((folder / "map.bt").string()));
  RC_ASSERT(difference(map, binary, false) == "");
  const std::unique_ptr<octomap::AbstractOcTree> full(
      octomap::AbstractOcTree::read((folder / "map.ot").string()));
  const auto* tree = dynamic_cast<const octomap::OcTree*>(full.get());
  RC_ASSERT(tree != nullptr);
  RC_ASSERT(difference(map, *tree, true) == "");
}

TEST(OctomapFiles, HoldAMapOfARoom) {
  VoxelMapConfig config;
  config.lowest = {-2.8, -2.8, -0.4};
  config.highest = {2.8, 2.8, 2.8};
  VoxelMap map(config);
  const auto room = SyntheticRoom::furnished();
  for (const double yaw : {-1.0, 0.0, 1.0}) {
    const Eigen::Isometry3d pose = camera_pose({-1, 0, 1.4}, yaw, 0.3);
    integrate(map, look(room, camera_of(170, 240, 0.6), pose), pose, at_seconds(1));
  }
  const TemporaryFolder folder;
  write_bt(map, folder / "map.bt");
  octomap::OcTree read(1.0);
  ASSERT_TRUE(read.readBinary((folder / "map.bt").string()));
  EXPECT_EQ(difference(map, read, false), "");
  EXPECT_GT(read.getNumLeafNodes(), 1000U);
}

TEST(OctomapFiles, AppearWholeOrNotAtAll) {
  const VoxelMap map{VoxelMapConfig{}};
  const TemporaryFolder folder;
  EXPECT_THROW(write_bt(map, folder / "missing" / "map.bt"), InputError);
  std::filesystem::create_directory(folder / "taken.bt");
  std::ofstream(folder / "taken.bt" / "file") << "in the way";
  EXPECT_THROW(write_bt(map, folder / "taken.bt"), InputError);
  write_bt(map, folder / "map.bt");
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    names.push_back(entry.path().filename().string());
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("map.bt", "taken.bt"));
}

}  // namespace
}  // namespace headway::nav
